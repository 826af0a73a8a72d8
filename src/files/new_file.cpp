// files/new_file.cpp: writes to a temporary name, syncs and renames.
#include "files/new_file.hpp"

namespace drover::files {

std::filesystem::path behind_links(std::filesystem::path name) {
    constexpr int max_links = 40;  // as the kernel
    std::filesystem::path file = name;
    std::error_code problem;
    for (int links = 0; std::filesystem::is_symlink(file, problem); ++links) {
        require(links < max_links, {name.string()}, "leads through more than {} symbolic links; expected a file",
                max_links);
        const std::filesystem::path target = std::filesystem::read_symlink(file);
        file = target.is_absolute() ? target : file.parent_path() / target;
    }
    return file;
}

namespace {

/// A rename would replace a device or a pipe.
std::filesystem::path plain_file(const std::filesystem::path& name) {
    const std::filesystem::path file = behind_links(name);
    std::error_code problem;
    const auto status = std::filesystem::status(file, problem);
    require(!std::filesystem::exists(status) || std::filesystem::is_regular_file(status), {name.string()},
            "is not a plain file; expected the name of one");
    return file;
}

}  // namespace

NewFile::NewFile(const std::filesystem::path& name) : file_(plain_file(name)), partial_(partial_name(file_)) {
    std::error_code unknown;
    is_new_ = !std::filesystem::exists(file_, unknown);
    try {
        to_ = create_file(partial_);
    } catch (const std::system_error& cause) {
        throw Error(fault_of(cause), {file_.string()},
                    text("cannot be written: {}; expected a file in a writable folder", std::string(cause.what())));
    }
}

NewFile::~NewFile() {
    std::error_code ignored;
    if (!is_finished_ && is_at(to_, partial_)) std::filesystem::remove(partial_, ignored);
}

template <class Work>
void NewFile::guarded(std::uint64_t bytes, Work work) {
    try {
        work();
    } catch (const std::system_error& cause) {
        throw write_failure(file_, cause, bytes, is_new_ ? "nothing of it is left" : "the file stays as it was");
    }
}

void NewFile::write(const std::string& part) {
    guarded(part.size(), [&] { write_at(to_, offset_, std::as_bytes(std::span(part))); });
    offset_ += part.size();
}

void NewFile::finish() {
    guarded(0, [&] {
        sync(to_);
        if (!is_at(to_, partial_))
            fail_run("{}: another process wrote this file at the same time; write to another name, or wait for it",
                     file_.string());
        rename_over(partial_, file_);
        is_finished_ = true;
        sync_folder_of(file_);
    });
}

void replace_file(const std::filesystem::path& name, const std::string& content) {
    NewFile file(name);
    file.write(content);
    file.finish();
}

void replace_archive(const std::filesystem::path& complete, const std::filesystem::path& name) {
    const std::filesystem::path file = plain_file(name);
    try {
        remove_if_exists(complete.string() + ".journal");
        rename_over(complete, file);
        sync_folder_of(file);
    } catch (const std::system_error& cause) {
        throw write_failure(file, cause, 0, "the file stays as it was");
    }
}

}  // namespace drover::files
