// tests/fuzz/targets.hpp: what reads input of strangers, as functions of bytes.
#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace drover::fuzz {

/// Reads the bytes as drover would.  Anything but success or an Error is a fault of drover.
struct Target {
    std::string name;
    std::function<void(std::span<const char>)> read;
};

/// scene, term, formula, archive, table, checkpoint, trials, xyz.
const std::vector<Target>& targets();

}  // namespace drover::fuzz
