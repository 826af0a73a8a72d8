// tests/files/input_file.cpp: input files are read whole or not at all, and failed reads are errors of the environment.
#include "files/input_file.hpp"

#include <sys/stat.h>

#include "files/support.hpp"

namespace drover::files::input_file_tests {
namespace {
using ::testing::HasSubstr;
using testing_support::Folder;
using testing_support::sentence_of;
using testing_support::write_contents;

/// A plain file of length 0, whose reads fail with EIO at address 0.
constexpr const char* failing_file = "/proc/self/mem";

/// The kind of the Error that `work` throws.
template <class Work>
std::optional<Fault> fault_of_error(Work work) {
    try {
        work();
    } catch (const Error& error) {
        return error.fault();
    }
    return std::nullopt;
}

TEST(InputFile, the_whole_file_is_read_also_where_it_has_no_length) {
    const Folder folder;
    std::string large(200000, 'a');  // more than one block
    large += "\nend";
    write_contents(folder / "large", large);
    EXPECT_EQ(read_text(folder / "large", "text", 1 << 20), large);
    EXPECT_THAT(read_text("/proc/self/status", "text", 1 << 20), HasSubstr("VmRSS"));  // of length 0
    write_contents(folder / "empty", "");
    EXPECT_EQ(read_text(folder / "empty", "text", 1 << 20), "");
}

TEST(InputFile, a_failed_read_is_an_error_of_the_environment_and_not_the_end_of_the_file) {
    EXPECT_THAT(sentence_of([] { read_text(failing_file, "text", 1 << 20); }),
                HasSubstr("/proc/self/mem: the disk reports a failure: read: Input/output error"));
    std::string line;
    EXPECT_EQ(fault_of_error([] { read_text(failing_file, "text", 1 << 20); }), Fault::environment);
    EXPECT_EQ(fault_of_error([] { read_start(failing_file, 8); }), Fault::environment);
    EXPECT_EQ(fault_of_error([&] { LineReader(failing_file, "text").next(line); }), Fault::environment);
}

TEST(InputFile, what_is_no_plain_file_of_the_right_size_is_rejected_and_a_pipe_is_not_waited_for) {
    const Folder folder;
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    write_contents(folder / "large", std::string(1001, 'a'));
    for (const auto& [name, words] :
         {std::pair{"none", "none: no such file; expected text"}, std::pair{"none/deeper", "no such file"},
          std::pair{"pipe", "pipe: is not a plain file"}, std::pair{".", "is not a plain file"},
          std::pair{"large", "large: larger than 1 kB; expected text"}}) {
        const auto read = [&, name = name] { read_text(folder / name, "text", 1000); };
        EXPECT_THAT(sentence_of(read), HasSubstr(words));
        EXPECT_EQ(fault_of_error(read), Fault::input);
    }
    EXPECT_EQ(read_start(folder / "pipe", 8), "");
    EXPECT_EQ(read_start(folder / "none", 8), "");
    EXPECT_EQ(read_start(folder / "large", 8), "aaaaaaaa");
}

TEST(InputFile, lines_of_any_length_up_to_a_limit_are_read_across_blocks) {
    const Folder folder;
    std::vector<std::string> expected{"", "a", std::string(65535, 'b'), std::string(70000, 'c'), "", "last"};
    for (const char* end : {"", "\n"}) {
        std::string content;
        for (const std::string& line : expected) content += line + "\n";
        content.pop_back();
        write_contents(folder / "lines", content + end);
        LineReader from(folder / "lines", "lines");
        std::vector<std::string> found;
        for (std::string line; from.next(line);) found.push_back(line);
        EXPECT_EQ(found, expected);
    }
    write_contents(folder / "long", "short\n" + std::string(2 << 20, 'a'));
    LineReader from(folder / "long", "lines");
    std::string line;
    EXPECT_TRUE(from.next(line));
    EXPECT_THAT(sentence_of([&] { from.next(line); }), HasSubstr("long:2: a line of more than 1 MiB"));
}

}  // namespace
}  // namespace drover::files::input_file_tests
