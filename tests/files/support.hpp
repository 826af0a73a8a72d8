// tests/files/support.hpp: a small run to archive, a temporary folder, and Python programs, for tests of files and io.
#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "drover/base/error.hpp"
#include "files/archive.hpp"

namespace drover::testing_support {

using namespace files;

/// A temporary folder, removed at the end of the test.
class Folder {
public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "drover-files-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    std::size_t count() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

private:
    std::filesystem::path path_;
};

inline std::vector<double> numbers(std::size_t count, double first = 1.0) {
    std::vector<double> result(count);
    for (std::size_t i = 0; i < count; ++i) result[i] = first + static_cast<double>(i);
    return result;
}

/// Two fields on a 5 by 4 grid and two observables, as in a run.
inline std::vector<Recording> sample_recordings(std::size_t nx = 5, std::size_t ny = 4) {
    const Axis x{"x", "mm", "position along x", numbers(nx, 0.5)}, y{"y", "mm", "position along y", numbers(ny, 0.5)};
    const Axis shell{"shell", "mm-1", "wavenumber of a shell", numbers(6)};
    return {{"/",
             {y, x},
             {{"rod_density", "mm-2", "rods per area, sigma", {"y", "x"}},
              {"polar_order_x", "mm-2", "sigma <cos>", {"y", "x"}}},
             1},
            {"/observables",
             {shell},
             {{"order", "1", "|mean p|/sigma", {}}, {"spectrum_density", "mm-2", "S(q)", {"shell"}}},
             4}};
}

inline const std::vector<Attribute> sample_attributes{{"scene", std::string("title = \"flock\"")},
                                                      {"seed", std::int64_t{7}},
                                                      {"dt", 0.125}};

/// The value of one element: arbitrary digits, reproducible.
inline double sample_value(std::size_t recording, std::size_t quantity, std::size_t row, std::size_t i) {
    return std::sin(1.0 + static_cast<double>(recording * 7 + quantity * 13 + row * 101 + i * 3));
}

inline std::size_t size_of(const Recording& recording, std::size_t quantity) {
    std::size_t size = 1;
    for (const std::string& name : recording.quantities[quantity].axes)
        for (const Axis& axis : recording.axes)
            if (axis.name == name) size *= axis.values.size();
    return size;
}

inline std::vector<double> sample_array(const std::vector<Recording>& recordings, std::size_t recording,
                                        std::size_t quantity, std::size_t row) {
    std::vector<double> array(size_of(recordings[recording], quantity));
    for (std::size_t i = 0; i < array.size(); ++i) array[i] = sample_value(recording, quantity, row, i);
    return array;
}

/// Appends the next row of every recording.
inline void append_samples(Archive& archive, const std::vector<Recording>& recordings) {
    for (std::size_t r = 0; r < recordings.size(); ++r) {
        const std::size_t row = archive.rows()[r];
        std::vector<std::vector<double>> arrays;
        for (std::size_t q = 0; q < recordings[r].quantities.size(); ++q)
            arrays.push_back(sample_array(recordings, r, q, row));
        const std::vector<std::span<const double>> spans(arrays.begin(), arrays.end());
        archive.append(r, 0.5 * static_cast<double>(row), spans);
    }
}

/// The number of rows of a file, after checking that all recordings have it and every value is the one appended.
inline std::size_t checked_rows(const std::filesystem::path& file, const std::vector<Recording>& recordings) {
    const ArchiveReader reader(file);
    const std::size_t rows = reader.shape("/time").at(0);
    for (std::size_t r = 0; r < recordings.size(); ++r) {
        const std::string group = recordings[r].group == "/" ? "/" : recordings[r].group + "/";
        EXPECT_EQ(reader.shape(group + "time").at(0), rows) << file;
        for (std::size_t row = 0; row < rows; ++row)
            EXPECT_EQ(reader.read(group + "time").values.at(row), 0.5 * static_cast<double>(row));
        for (std::size_t q = 0; q < recordings[r].quantities.size(); ++q)
            for (std::size_t row = 0; row < rows; ++row)
                EXPECT_EQ(reader.read_row(group + recordings[r].quantities[q].name, row).values,
                          sample_array(recordings, r, q, row))
                    << file << " row " << row;
    }
    return rows;
}

/// Writes a file of samples with `rows` commits of one row each.
inline void make_sample(const std::filesystem::path& file, std::size_t rows,
                        const std::vector<Recording>& recordings = sample_recordings()) {
    Archive archive = Archive::create(file, recordings, sample_attributes, false);
    for (std::size_t row = 0; row < rows; ++row) {
        append_samples(archive, recordings);
        archive.commit();
    }
}

/// The message of the Error that `work` throws; "" if it throws none.
template <class Work>
std::string sentence_of(Work work) {
    try {
        work();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

inline std::string contents(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_contents(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

/// The output of a Python script, including its errors.  sys.argv[1] is `path`.
inline std::string python(const std::string& script, const std::filesystem::path& path) {
    const Folder folder;
    write_contents(folder / "script.py", script);
    const std::string command =
        "/usr/bin/python3 '" + (folder / "script.py").string() + "' '" + path.string() + "' 2>&1";
    std::string output;
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return "no python";
    for (int letter = std::fgetc(pipe); letter != EOF; letter = std::fgetc(pipe))
        output.push_back(static_cast<char>(letter));
    ::pclose(pipe);
    return output;
}

inline bool has_python(const std::string& modules) {
    return std::system(("/usr/bin/python3 -c 'import " + modules + "' > /dev/null 2>&1").c_str()) == 0;
}

}  // namespace drover::testing_support
