// files/lost_file.cpp: finds out what happened to a file, rescues what can be rescued, and says so.
#include "files/lost_file.hpp"

#include <algorithm>
#include <cerrno>

#include "files/checkpoint.hpp"

namespace drover::files {
namespace {

constexpr const char* hopeless = "the run cannot be resumed; run the scene again";

/// NFS keeps a file that was removed, under such a name, until it is closed.
bool has_no_name(const Overlay& overlay) {
    return link_count(overlay.file) == 0 || name_of(overlay.file).filename().string().starts_with(".nfs");
}

bool has_checkpoint(const std::filesystem::path& archive) {
    const auto files = checkpoint_files(archive);
    std::error_code unknown;
    return std::any_of(files.begin(), files.end(),
                       [&](const auto& file) { return std::filesystem::exists(file, unknown); });
}

/// Writes the last commit to a name that nothing has.
void copy_to(const Overlay& overlay, const std::filesystem::path& name) {
    if (std::filesystem::exists(name)) throw std::system_error(EEXIST, std::generic_category(), name.string());
    const std::filesystem::path partial = partial_name(name);
    const Descriptor to = create_file(partial);
    std::vector<std::byte> part(1 << 20);
    for (std::uint64_t offset = 0; offset < overlay.committed; offset += part.size()) {
        part.resize(static_cast<std::size_t>(std::min<std::uint64_t>(part.size(), overlay.committed - offset)));
        if (read_at(overlay.file, offset, part) < part.size())
            throw std::system_error(EIO, std::generic_category(), "read");
        write_at(to, offset, part);
    }
    sync(to);
    rename_over(partial, name);
    sync_folder_of(name);
}

/// What becomes of a file without a name.
std::string rescued(const Overlay& overlay, bool is_replaced) {
    const std::string path = overlay.path.string();
    const std::string what = is_replaced ? "was replaced by another file" : "was deleted";
    if (!has_checkpoint(overlay.path))
        return text("the archive {} while the run wrote it, and no checkpoint is left: {}", what, hopeless);
    const std::string name = is_replaced ? path + ".rescued" : path;
    try {
        copy_to(overlay, name);
    } catch (const std::exception& cause) {
        return text("the archive {} while the run wrote it, and cannot be written again ({}): {}", what,
                    std::string(cause.what()), hopeless);
    }
    if (is_replaced)
        return text(
            "the archive {} while the run wrote it; as of its last commit it is now {}; to resume, move that "
            "to {}, then: drover restart {}",
            what, name, path, path);
    return text(
        "the archive {} while the run wrote it; it was written again as of its last commit; to resume: drover "
        "restart {}",
        what, path);
}

/// The file is still open and has its data: what a person can do about its name.
std::string renamed(const Overlay& overlay) {
    const std::string path = overlay.path.string(), now = name_of(overlay.file).string();
    if (!has_checkpoint(overlay.path))
        return text("the archive was moved while the run wrote it, and no checkpoint is left: {}", hopeless);
    return text(
        "the archive was moved to {} while the run wrote it; to resume, move it back to {}, then: drover "
        "restart {}",
        now.empty() ? "another name" : now, path, path);
}

/// What happened to the file; "" if nothing did.
std::string loss_of(const Overlay& overlay) {
    const Named name = named(overlay.file, overlay.path);
    if (name != Named::this_file)
        return has_no_name(overlay) ? rescued(overlay, name == Named::another_file) : renamed(overlay);
    if (const std::uint64_t length = length_of(overlay.file); length < overlay.committed)
        return text("another program cut the archive to {} of {} bytes while the run wrote it: {}", length,
                    overlay.committed, hopeless);
    const FileMark& mark = overlay.mark;
    if (head_of(overlay.file) == mark.head && text_at(overlay.file, mark.offset, mark.run_id.size()) == mark.run_id)
        return "";
    return text("another program overwrote the archive while the run wrote it: {}", hopeless);
}

}  // namespace

void require_in_place(Overlay& overlay) {
    if (!overlay.is_written || overlay.committed == 0 || overlay.is_stuck || overlay.failure) return;
    try {
        const std::string loss = loss_of(overlay);
        if (loss.empty()) return;
        overlay.failure = std::make_exception_ptr(Error(Fault::run, {overlay.path.string()}, loss));
    } catch (const std::system_error& cause) {
        throw disk_failure(overlay.path, cause);
    }
    std::rethrow_exception(overlay.failure);
}

void remove_in_place(const Overlay& overlay) {
    if (named(overlay.file, overlay.path) == Named::this_file) remove_if_exists(overlay.path);
}

}  // namespace drover::files
