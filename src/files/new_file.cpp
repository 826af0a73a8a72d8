// files/new_file.cpp: writes to a temporary name, syncs and renames.
#include "files/new_file.hpp"

#include "files/system_calls.hpp"

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

struct NewFile::File {
    std::filesystem::path file, partial;
    Descriptor to;
    std::uint64_t offset = 0;
    bool is_finished = false, is_new = true;

    ~File() {
        std::error_code ignored;
        if (to.is_open() && !is_finished && is_at(to, partial)) std::filesystem::remove(partial, ignored);
    }

    template <class Work>
    void guarded(std::uint64_t bytes, Work work) {
        try {
            work();
        } catch (const std::system_error& cause) {
            throw write_failure(file, cause, bytes, is_new ? "nothing of it is left" : "the file stays as it was");
        }
    }
};

NewFile::NewFile(const std::filesystem::path& name) : file_(std::make_unique<File>()) {
    const std::filesystem::path file = plain_file(name);
    file_->file = file;
    file_->partial = partial_name(file);
    std::error_code unknown;
    file_->is_new = !std::filesystem::exists(file, unknown);
    try {
        file_->to = create_file(file_->partial);
    } catch (const std::system_error& cause) {
        throw Error(fault_of(cause), {file.string()},
                    text("cannot be written: {}; expected a file in a writable folder", std::string(cause.what())));
    }
}

NewFile::NewFile(NewFile&&) noexcept = default;
NewFile::~NewFile() = default;

void NewFile::write(const std::string& part) {
    file_->guarded(part.size(), [&] { write_at(file_->to, file_->offset, std::as_bytes(std::span(part))); });
    file_->offset += part.size();
}

void NewFile::finish() {
    file_->guarded(0, [&] {
        sync(file_->to);
        if (!is_at(file_->to, file_->partial))
            fail_run("{}: another process wrote this file at the same time; write to another name, or wait for it",
                     file_->file.string());
        rename_over(file_->partial, file_->file);
        file_->is_finished = true;
        sync_folder_of(file_->file);
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
