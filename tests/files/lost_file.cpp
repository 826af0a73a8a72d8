// tests/files/lost_file.cpp: archives that another program removes, replaces or changes; journals of other files.
#include <fcntl.h>

#include "files/checkpoint.hpp"
#include "files/journal.hpp"
#include "files/support.hpp"

namespace drover::files::lost_file_tests {
namespace {

using namespace testing_support;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

/// An archive with two committed rows and a third that is not committed, and a checkpoint.
class LostFile : public ::testing::Test {
protected:
    LostFile() {
        std::vector<Attribute> attributes = sample_attributes;
        attributes.emplace_back(run_id_name, draw_run_id());
        archive_.emplace(Archive::create(file_, recordings_, attributes, false));
        for (int row = 0; row < 2; ++row) {
            append_samples(*archive_, recordings_);
            archive_->commit();
        }
        write_checkpoint(file_, {.scene = "", .state = {1.0}});
        append_samples(*archive_, recordings_);
    }
    /// The sentence of the run Error of a commit, which a second commit repeats.
    std::string sentence() {
        try {
            archive_->commit();
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::environment);  // not of the scene
            EXPECT_EQ(sentence_of([&] { archive_->commit(); }), error.what());
            return error.what();
        }
        return "";
    }

    Folder folder_;
    fs::path file_ = folder_ / "run.h5";
    std::vector<Recording> recordings_ = sample_recordings();
    std::optional<Archive> archive_;
};

TEST_F(LostFile, an_archive_that_was_deleted_is_written_again_as_of_the_last_commit) {
    fs::remove(file_);
    EXPECT_THAT(sentence(), AllOf(HasSubstr("the archive was deleted while the run wrote it; it was written again"),
                                  HasSubstr("to resume: drover restart " + file_.string())));
    EXPECT_EQ(checked_rows(file_, recordings_), 2u);
    EXPECT_EQ(folder_.count(), 2u);
}

TEST_F(LostFile, without_a_checkpoint_it_does_not_promise_a_restart) {
    for (const auto& entry : fs::directory_iterator(file_.parent_path())) fs::remove(entry);
    EXPECT_THAT(sentence(), AllOf(HasSubstr("was deleted while the run wrote it, and no checkpoint is left: the run "
                                            "cannot be resumed"),
                                  Not(HasSubstr("restart"))));
    EXPECT_EQ(folder_.count(), 0u);
}

TEST_F(LostFile, an_archive_that_was_replaced_is_written_beside_the_other_file) {
    fs::remove(file_);
    write_contents(file_, "a thesis");
    EXPECT_THAT(sentence(),
                HasSubstr("was replaced by another file while the run wrote it; as of its last commit it is "
                          "now " +
                          file_.string() + ".rescued; to resume, move that to"));
    EXPECT_EQ(contents(file_), "a thesis");
    EXPECT_EQ(checked_rows(file_.string() + ".rescued", recordings_), 2u);
    archive_->remove();
    EXPECT_EQ(contents(file_), "a thesis");
}

TEST_F(LostFile, nothing_is_overwritten_by_what_is_rescued) {
    fs::remove(file_);
    for (const char* end : {"", ".rescued"}) write_contents(file_.string() + end, "a thesis");
    EXPECT_THAT(sentence(), AllOf(HasSubstr("cannot be written again"), HasSubstr("the run cannot be resumed")));
    EXPECT_EQ(contents(file_.string() + ".rescued"), "a thesis");
}

TEST_F(LostFile, of_an_archive_that_was_moved_the_new_name_is_reported) {
    fs::rename(file_, folder_ / "away.h5");
    EXPECT_THAT(sentence(), HasSubstr("was moved to " + (folder_ / "away.h5").string() +
                                      " while the run wrote it; to resume, move it back to " + file_.string()));
    EXPECT_EQ(checked_rows(folder_ / "away.h5", recordings_), 2u);
    EXPECT_FALSE(fs::exists(file_));
}

TEST_F(LostFile, an_archive_that_was_cut_or_overwritten_ends_the_run_without_a_promise) {
    const std::string whole = contents(file_);
    fs::resize_file(file_, 100);
    EXPECT_THAT(sentence(), AllOf(HasSubstr(text("cut the archive to 100 of {} bytes", whole.size())),
                                  HasSubstr("cannot be resumed"), Not(HasSubstr("drover restart"))));
    EXPECT_EQ(fs::file_size(file_), 100u);
}

TEST_F(LostFile, an_archive_with_the_bytes_of_another_run_ends_the_run) {
    std::vector<Attribute> attributes = sample_attributes;
    attributes.emplace_back(run_id_name, draw_run_id());
    {
        Archive other = Archive::create(folder_ / "other.h5", recordings_, attributes, false);
        for (int row = 0; row < 2; ++row) {
            append_samples(other, recordings_);
            other.commit();
        }
    }
    const std::string theirs = contents(folder_ / "other.h5");
    EXPECT_EQ(theirs.size(), contents(file_).size());  // they differ in the run id alone
    write_contents(file_, theirs);
    EXPECT_THAT(sentence(), AllOf(HasSubstr("another program overwrote the archive"), HasSubstr("cannot be resumed")));
    EXPECT_EQ(contents(file_), theirs);
}

TEST_F(LostFile, what_does_not_change_the_content_does_not_end_the_run) {
    fs::last_write_time(file_, fs::last_write_time(file_) + std::chrono::hours(1));
    fs::create_hard_link(file_, folder_ / "kept.h5");
    EXPECT_EQ(sentence(), "");
    EXPECT_EQ(checked_rows(file_, recordings_), 3u);
}

/// A file with a run id, and the journal of a commit that changes its first page.
struct Journaled {
    Folder folder;
    fs::path file = folder / "run.h5";
    std::string content = std::string(100, 'a') + "90f3a1b7" + std::string(8084, 'b');
    Journal journal{.length = 8192, .patches = {{0, std::vector<std::byte>(64, std::byte{'c'})}}};

    Journaled() {
        write_contents(file, content);
        journal.before = FileMark{.run_id = "90f3a1b7", .offset = 100, .head = head_of(open())};
        write_contents(file, after());
        journal.head_after = head_of(open());
        write_contents(file, content);
    }
    Descriptor open() const { return open_file(file, O_RDWR); }
    std::string after() const { return std::string(64, 'c') + content.substr(64); }
    std::string recovered() {
        write_journal(file, encoded(journal));
        const std::string sentence = sentence_of([&] { recover(open(), file); });
        EXPECT_EQ(fs::exists(journal_of(file)), !sentence.empty());
        return sentence;
    }
};

TEST(Journal, is_applied_to_the_file_before_and_after_its_commit) {
    Journaled one;
    for (int times = 0; times < 2; ++times) {
        EXPECT_EQ(one.recovered(), "");
        EXPECT_EQ(contents(one.file), one.after());
    }
}

TEST(Journal, of_another_run_or_another_commit_is_rejected_and_kept) {
    Journaled one;
    const std::string other = std::string(one.content).replace(100, 8, "00000000");
    write_contents(one.file, other);
    EXPECT_THAT(one.recovered(), AllOf(HasSubstr("run.h5.journal: holds the last commit of another file, with run_id = "
                                                 "90f3a1b7"),
                                       HasSubstr("or remove the journal")));
    EXPECT_EQ(contents(one.file), other);
    const std::string shorter = one.content.substr(0, 8000);
    write_contents(one.file, shorter);
    EXPECT_THAT(one.recovered(), HasSubstr("holds a commit that does not follow the last one of"));
    EXPECT_EQ(contents(one.file), shorter);
    const std::string later = std::string(one.content).replace(0, 4, "9999");
    write_contents(one.file, later);
    EXPECT_THAT(one.recovered(), HasSubstr("holds a commit that does not follow the last one of"));
    EXPECT_EQ(contents(one.file), later);
}

}  // namespace
}  // namespace drover::files::lost_file_tests
