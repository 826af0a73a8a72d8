// tests/bench/particles/plain_rod.cpp: frames of plain_rod.hpp as lines "x y nx ny".
// Usage: plain_rod SEED SECONDS SPACING STEP KICK FRICTION ORDER BEARING, in the words of the keys of a scene.
#include "plain_rod.hpp"

#include <cstdio>
#include <cstdlib>

int main(int count, char** words) {
    if (count != 9) return 2;
    plain::Choice choice;
    choice.step = std::atof(words[4]);
    choice.kick = std::atof(words[5]);
    choice.decoupled = words[6] == std::string("decoupled");
    choice.order = words[7];
    choice.hull = words[8] == std::string("hull");
    const auto seed = static_cast<std::uint64_t>(std::atoll(words[1]));
    for (const plain::Frame& f : plain::run(choice, seed, std::atof(words[2]), std::atof(words[3])))
        std::printf("%.17g %.17g %.17g %.17g\n", f.x, f.y, f.nx, f.ny);
    return 0;
}
