// tests/io/calibration.cpp: tables of coefficients to a file and back; foreign files.
#include "io/calibration.hpp"

#include <cmath>

#include "base/refusal.hpp"
#include "files/support.hpp"

namespace drover::io::calibration_tests {
namespace {

using testing_support::Folder;

calibrate::Table sample_table(bool varied) {
    calibrate::Table table{.varied_key = varied ? "kick.strength" : "",
                           .varied = varied ? std::vector<double>{0.01, 0.02} : std::vector<double>{0.0},
                           .bead_fractions = {0.2, 0.4, 0.6},
                           .rod_fractions = {0.05, 0.1},
                           .rows = {}};
    for (const bool by_rods : {false, true}) {
        calibrate::TableRow row{.name = by_rods ? "drag" : "relaxation_rate",
                                .unit = by_rods ? "mm/s" : "1/s",
                                .formula = by_rods ? "alpha/Gamma" : "a = D_r",
                                .by_rods = by_rods};
        for (std::size_t i = 0; i < calibrate::count_of(table, by_rods); ++i)
            row.entries.push_back({.value = std::sin(static_cast<double>(i)),
                                   .error = 0.01 * static_cast<double>(i),
                                   .trials = static_cast<int>(32 + i),
                                   .origin = static_cast<calibrate::Origin>(1 + i % 4),
                                   .remark = i % 2 == 0 ? "" : text("remark: number {}", i)});
        table.rows.push_back(std::move(row));
    }
    for (std::size_t k = 0; k < calibrate::resample_count; ++k)  // of some entries of one row
        for (const std::size_t i : {0, 4})
            table.rows[1].entries[i].ranks.push_back(static_cast<double>(77 * k % calibrate::resample_count));
    table.rows[1].entries[3] = {.value = NAN, .error = NAN, .trials = 8, .remark = "every rod\njams"};
    return table;
}

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(CalibrationFile, a_table_reads_back_unchanged) {
    const Folder folder;
    for (const bool varied : {false, true}) {
        const calibrate::Table table = sample_table(varied);
        const auto path = folder / "table.h5";
        write_calibration(path, table, {{"scene", std::string("[kick]")}});
        const calibrate::Table found = read_calibration(path);
        EXPECT_EQ(found.varied_key, table.varied_key);
        EXPECT_EQ(found.varied, table.varied);
        EXPECT_EQ(found.bead_fractions, table.bead_fractions);
        EXPECT_EQ(found.rod_fractions, table.rod_fractions);
        ASSERT_EQ(found.rows.size(), table.rows.size());
        for (std::size_t r = 0; r < found.rows.size(); ++r) {
            const calibrate::TableRow &a = found.rows[r], &b = table.rows[r];
            EXPECT_EQ(std::tie(a.name, a.unit, a.formula, a.by_rods), std::tie(b.name, b.unit, b.formula, b.by_rods));
            ASSERT_EQ(a.entries.size(), b.entries.size());
            for (std::size_t i = 0; i < a.entries.size(); ++i) {
                const bool hole = b.entries[i].origin == calibrate::Origin::missing;
                EXPECT_TRUE(hole ? std::isnan(a.entries[i].value) : a.entries[i].value == b.entries[i].value);
                EXPECT_TRUE(hole ? std::isnan(a.entries[i].error) : a.entries[i].error == b.entries[i].error);
                EXPECT_EQ(a.entries[i].trials, b.entries[i].trials);
                EXPECT_EQ(a.entries[i].ranks, b.entries[i].ranks);
                EXPECT_EQ(a.entries[i].origin, b.entries[i].origin);
                EXPECT_EQ(a.entries[i].remark, hole ? "every rod jams" : b.entries[i].remark);
            }
        }
        EXPECT_EQ(folder.count(), 1u);  // no temporary file is left
    }
}

TEST(CalibrationFile, the_same_table_gives_the_same_bytes) {
    const Folder folder;
    write_calibration(folder / "a.h5", sample_table(true), {{"scene", std::string("x")}});
    write_calibration(folder / "b.h5", sample_table(true), {{"scene", std::string("x")}});
    write_calibration(folder / "b.h5", sample_table(true), {{"scene", std::string("x")}});  // also overwrites another
    EXPECT_EQ(bytes_of(folder / "a.h5"), bytes_of(folder / "b.h5"));
}

TEST(CalibrationFile, a_table_with_negative_errors_is_rejected) {
    const Folder folder;
    calibrate::Table table = sample_table(false);
    table.rows[0].entries[1].error = -1.0;
    EXPECT_NE(refusal_of([&] { write_calibration(folder / "t.h5", table, {}); }).find("has the standard error -1"),
              std::string::npos);
    EXPECT_EQ(folder.count(), 0u);
}

/// A file with these datasets in /calibration and attributes that name one coefficient.
void write_raw(const std::filesystem::path& file, std::vector<double> errors, std::vector<double> origins,
               std::size_t rods, bool whole) {
    const std::vector<std::string> axes{"bead_area_fraction", "rod_area_fraction"};
    files::ResultTable raw{.group = "/calibration",
                           .axes = {{"bead_area_fraction", "1", "", {0.2, 0.4}},
                                    {"rod_area_fraction", "1", "", testing_support::numbers(rods, 0.01)}},
                           .quantities = {{"drag", "mm/s", "alpha/Gamma", axes},
                                          {"drag_error", "mm/s", "", {"bead_area_fraction"}},
                                          {"drag_trials", "1", "", axes, true},
                                          {"drag_origin", "1", "", {"bead_area_fraction"}, true}},
                           .values = {std::vector<double>(2 * rods, 1.0), std::move(errors),
                                      std::vector<double>(2 * rods, 32.0), std::move(origins)}};
    if (rods == 1)
        for (files::Quantity& quantity : raw.quantities) quantity.axes = {"bead_area_fraction"};
    if (!whole) {
        raw.quantities.pop_back();
        raw.values.pop_back();
    }
    files::Archive archive =
        files::Archive::create(file, {},
                               {{"coefficients", std::string("drag")},
                                {"varied", std::string()},
                                {"remarks", std::string("nonsense\ndrag[x: 1\ndrag[9]: none\n]: [drag")}},
                               true);
    archive.replace(raw);
    archive.commit();
}

TEST(CalibrationFile, foreign_files_are_rejected_with_a_message) {
    const Folder folder;
    const auto path = folder / "t.h5";
    const auto why_no_error = [&] { return refusal_of([&] { read_calibration(path); }); };
    write_raw(path, {0.1, 0.1}, {1, 1}, 1, true);
    EXPECT_EQ(why_no_error(), "no refusal");
    write_raw(path, {0.1, -0.1}, {1, 1}, 1, true);
    EXPECT_EQ(why_no_error(),
              path.string() + ": drag at bead area fraction 0.4 has the standard error -0.1; expected a number >= 0");
    write_raw(path, {0.1, NAN}, {1, 1}, 1, true);
    EXPECT_NE(why_no_error().find("has the standard error nan"), std::string::npos);
    write_raw(path, {0.1, 0.1}, {1, 7}, 1, true);
    EXPECT_EQ(why_no_error(), path.string() + ": drag_origin holds 7; expected 0 to 4");
    write_raw(path, {0.1, 0.1}, {1, 1}, 2, true);
    EXPECT_EQ(why_no_error(),
              path.string() + ": /calibration/drag_error has 2 numbers; expected 2 by 2, the sizes of the axes");
    write_raw(path, {0.1, 0.1}, {1, 1}, 1, false);
    EXPECT_EQ(why_no_error(), path.string() +
                                  ": /calibration/drag_origin is missing; expected a complete table written by drover "
                                  "calibrate");
    {
        files::Archive archive = files::Archive::create(path, {}, testing_support::sample_attributes, true);
        archive.commit();
    }
    EXPECT_EQ(why_no_error(), path.string() +
                                  ": not a table of coefficients: /bead_area_fraction is missing; expected a file "
                                  "written by drover calibrate");
    std::ofstream(path) << "value = 1";
    EXPECT_EQ(why_no_error(), path.string() + ": is not an HDF5 file; expected an archive of drover");
}

}  // namespace
}  // namespace drover::io::calibration_tests
