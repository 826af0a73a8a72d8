// jobs/share.hpp: a process's part of work that many processes share.
#pragma once
namespace drover::jobs {

/// One of so many processes that share the work in a folder.  They take it in small batches, each beginning elsewhere:
/// none has a fixed part.
struct Share {
    int number = 1, count = 1;
    bool is_plain() const { return count == 1; }
};

}  // namespace drover::jobs
