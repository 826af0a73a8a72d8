// tests/files/claims.cpp: claims have one owner; those of dead owners, on this machine and on others, are taken again.
#include "files/claims.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include "files/support.hpp"

namespace drover::files::claims_tests {
namespace {

using namespace std::chrono_literals;
using testing_support::Folder;

Claimant neighbour() { return this_process(1, 1, 1); }

/// A process of another machine, as far as claims can see.
Claimant elsewhere() {
    Claimant claimant = this_process(1, 1, 1);
    claimant.machine = "another kernel " + claimant.id;
    return claimant;
}

/// Runs `work` in a child process, which ends by kill -9 when that returns.
template <class Work>
void run_and_kill(Work work) {
    const pid_t child = ::fork();
    if (child == 0) {
        work();
        ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
}

TEST(Claims, one_of_two_processes_gets_a_key_and_the_other_when_it_is_released) {
    const Folder folder;
    Claims one(folder / "claims", neighbour()), other(folder / "claims", neighbour());
    EXPECT_EQ(one.holder("unit"), Held::no);
    EXPECT_TRUE(one.claim("unit"));
    EXPECT_TRUE(one.claim("unit"));  // it has it
    EXPECT_FALSE(other.claim("unit"));
    EXPECT_EQ(other.holder("unit"), Held::certainly);
    EXPECT_TRUE(other.claim("another"));
    one.release("unit");
    EXPECT_TRUE(other.claim("unit"));
    EXPECT_FALSE(one.claim("unit"));
}

TEST(Claims, a_process_that_takes_more_memory_stays_the_same_process) {
    const Folder folder;
    Claims one(folder / "claims", neighbour()), other(folder / "claims", neighbour());
    ASSERT_TRUE(one.claim("unit"));
    constexpr std::size_t length = 1 << 28;  // of addresses alone
    void* addresses = ::mmap(nullptr, length, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(addresses, MAP_FAILED);
    EXPECT_EQ(other.holder("unit"), Held::certainly);
    EXPECT_FALSE(other.claim("unit"));
    ::munmap(addresses, length);
}

TEST(Claims, all_are_released_at_the_end) {
    const Folder folder;
    { EXPECT_TRUE(Claims(folder / "claims", neighbour()).claim("unit")); }
    EXPECT_TRUE(std::filesystem::is_empty(folder / "claims"));
}

TEST(Claims, those_of_a_killed_process_of_this_machine_are_free_at_once) {
    const Folder folder;
    for (int kills = 1; kills <= 3; ++kills) {  // also those of one that took them from a dead one
        run_and_kill([&] { return Claims(folder / "claims", neighbour()).claim("unit") ? ::raise(SIGKILL) : 0; });
        const std::vector<ClaimHolder> holders = claim_holders(folder / "claims");
        ASSERT_EQ(holders.size(), static_cast<std::size_t>(kills));
        for (const ClaimHolder& holder : holders) EXPECT_FALSE(holder.is_alive);
    }
    Claims next(folder / "claims", neighbour());
    EXPECT_EQ(next.holder("unit"), Held::no);
    EXPECT_TRUE(next.claim("unit"));
    Claims late(folder / "claims", neighbour());
    EXPECT_FALSE(late.claim("unit"));
    EXPECT_EQ(late.holder("unit"), Held::certainly);
    next.release("unit");
    EXPECT_TRUE(late.claim("unit"));
}

TEST(Claims, a_process_that_has_ended_and_waits_for_its_parent_is_dead) {
    const Folder folder;
    const pid_t child = ::fork();
    if (child == 0) {
        new Claims(folder / "claims", neighbour());
        static_cast<void>((new Claims(folder / "claims", neighbour()))->claim("unit"));
        ::_exit(0);
    }
    siginfo_t about{};
    ::waitid(P_PID, static_cast<id_t>(child), &about, WEXITED | WNOWAIT);  // it stays a zombie
    Claims next(folder / "claims", neighbour());
    EXPECT_TRUE(next.claim("unit"));
    ::waitpid(child, nullptr, 0);
}

TEST(Claims, a_process_of_another_machine_lives_while_its_heartbeat_does) {
    const Folder folder;
    const ClaimTimes times{.renewal = 20ms, .death = 400ms};
    Claims far(folder / "claims", elsewhere(), times), here(folder / "claims", neighbour(), times);
    ASSERT_TRUE(far.claim("unit"));
    EXPECT_FALSE(here.claim("unit"));
    EXPECT_EQ(here.holder("unit"), Held::maybe);  // one look shows no heart that beats
    for (int i = 0; i < 30; ++i) {                // longer than the time after which it would be dead
        std::this_thread::sleep_for(20ms);
        far.renew();
        here.renew();
        ASSERT_FALSE(here.claim("unit")) << i;
    }
    EXPECT_EQ(here.holder("unit"), Held::certainly);
    // Now it is silent, and this process is not.
    bool is_claimed = false;
    const auto begin = std::chrono::steady_clock::now();
    while (!is_claimed && std::chrono::steady_clock::now() - begin < 10s) {
        std::this_thread::sleep_for(20ms);
        here.renew();
        is_claimed = here.claim("unit");
    }
    EXPECT_TRUE(is_claimed);
    EXPECT_GT(std::chrono::steady_clock::now() - begin, 300ms);
    EXPECT_NE(far.holder("unit"), Held::no);  // if it lives after all, it sees that
}

TEST(Claims, a_file_server_whose_clock_is_set_back_does_not_keep_the_dead_alive) {
    const Folder folder;
    const ClaimTimes times{.renewal = 20ms, .death = 300ms};
    {
        Claims far(folder / "claims", elsewhere(), times);
        ASSERT_TRUE(far.claim("unit"));
        for (const auto& entry : std::filesystem::directory_iterator(folder / "claims"))  // one inode
            std::filesystem::last_write_time(entry.path(), std::filesystem::file_time_type::clock::now() + 24h);
        Claims here(folder / "claims", neighbour(), times);
        EXPECT_FALSE(here.claim("unit"));
        std::this_thread::sleep_for(500ms);
        EXPECT_TRUE(here.claim("unit"));
    }
}

TEST(Claims, a_process_with_a_clock_far_behind_lives_while_its_heartbeat_changes) {
    const Folder folder;
    const ClaimTimes times{.renewal = 100ms, .death = 1000ms};
    Claims far(folder / "claims", elsewhere(), times), here(folder / "claims", neighbour(), times);
    ASSERT_TRUE(far.claim("unit"));
    const std::filesystem::path heart = folder / "claims" / ("owner-" + far.claimant().id);
    auto beat = [&, time = std::filesystem::file_time_type::clock::now() - 24h]() mutable {
        std::filesystem::last_write_time(heart, time += 100ms);
    };
    for (int i = 0; i < 10; ++i) {
        beat();
        EXPECT_FALSE(here.claim("unit")) << i;
        here.renew();
        std::this_thread::sleep_for(30ms);
    }
    beat();
    EXPECT_EQ(here.holder("unit"), Held::certainly);
    std::this_thread::sleep_for(300ms);  // silent for two renewals, and so dead by the clock of the server
    EXPECT_TRUE(here.claim("unit"));
}

TEST(Claims, a_process_that_the_system_hides_is_judged_by_its_heartbeat) {
    constexpr uid_t nobody = 65534;
    const Folder folder;
    std::filesystem::permissions(folder / "", std::filesystem::perms::all);
    ASSERT_TRUE(std::filesystem::create_directory(folder / "claims"));
    std::filesystem::permissions(folder / "claims", std::filesystem::perms::all);
    Claims here(folder / "claims", neighbour());
    ASSERT_TRUE(here.claim("unit"));
    const pid_t child = ::fork();
    if (child == 0) {
        constexpr int cannot = 77;
        if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
            ::mount("proc", "/proc", "proc", 0, "hidepid=2") != 0 || ::setgid(nobody) != 0 || ::setuid(nobody) != 0)
            ::_exit(cannot);
        Claims other(folder / "claims", neighbour());
        ::_exit(other.holder("unit") == Held::no ? 1 : 0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "only root can hide processes";
    EXPECT_EQ(status, 0);
}

TEST(Claims, of_many_processes_that_take_one_from_a_dead_one_a_single_one_gets_it) {
    constexpr int processes = 8, keys = 50;
    const Folder folder;
    run_and_kill([&] {
        Claims dead(folder / "claims", neighbour());
        for (int k = 0; k < keys; ++k) dead.claim(text("unit-{}", k));
        ::raise(SIGKILL);
    });
    std::vector<pid_t> children;
    for (int i = 0; i < processes; ++i) {
        const pid_t child = ::fork();
        if (child == 0) {
            Claims& claims = *new Claims(folder / "claims", neighbour());
            for (int k = 0; k < keys; ++k)
                if (claims.claim(text("unit-{}", k))) std::ofstream((folder / text("got-{}-{}", k, i)).string());
            ::pause();  // alive, so that it keeps them
        }
        children.push_back(child);
    }
    std::multiset<int> got;
    for (int tries = 0; tries < 1000 && got.size() < keys; ++tries) {
        std::this_thread::sleep_for(10ms);
        got.clear();
        for (int k = 0; k < keys; ++k)
            for (int i = 0; i < processes; ++i)
                if (std::filesystem::exists(folder / text("got-{}-{}", k, i))) got.insert(k);
    }
    std::this_thread::sleep_for(50ms);
    for (const pid_t child : children) {
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
    }
    EXPECT_EQ(got.size(), static_cast<std::size_t>(keys));
    EXPECT_EQ(std::set<int>(got.begin(), got.end()).size(), static_cast<std::size_t>(keys));
}

TEST(Claims, what_dead_processes_leave_is_removed_when_another_starts) {
    const Folder folder;
    for (int i = 0; i < 5; ++i)
        run_and_kill([&] {
            new Claims(folder / "claims", neighbour());
            ::raise(SIGKILL);
        });
    { const Claims next(folder / "claims", neighbour()); }
    EXPECT_TRUE(std::filesystem::is_empty(folder / "claims"));
}

TEST(Claims, an_empty_file_of_a_process_that_was_killed_at_its_start_is_removed_after_the_time_of_death) {
    const Folder folder;
    std::filesystem::create_directories(folder / "claims");
    const auto now = std::filesystem::file_time_type::clock::now();
    for (const auto& [name, age] : {std::pair{"owner-old", 1000s}, std::pair{"owner-new", 0s}}) {
        std::ofstream(folder / "claims" / name).close();
        std::filesystem::last_write_time(folder / "claims" / name, now - age);
    }
    const Claims claims(folder / "claims", neighbour());
    EXPECT_FALSE(std::filesystem::exists(folder / "claims" / "owner-old"));
    EXPECT_TRUE(std::filesystem::exists(folder / "claims" / "owner-new"));
}

TEST(Claims, those_of_dead_processes_can_be_removed_and_those_of_the_living_stay) {
    const Folder folder;
    run_and_kill([&] {
        (new Claims(folder / "claims", neighbour()))->claim("dead");
        ::raise(SIGKILL);
    });
    Claims alive(folder / "claims", neighbour()), other(folder / "claims", neighbour());
    ASSERT_TRUE(alive.claim("unit"));
    other.remove_dead();
    EXPECT_FALSE(std::filesystem::exists(folder / "claims/dead.0"));
    EXPECT_FALSE(other.claim("unit"));
}

TEST(Claims, holders_are_listed_with_their_shares) {
    const Folder folder;
    EXPECT_TRUE(claim_holders(folder / "claims").empty());
    Claimant claimant = neighbour();
    claimant.share = 3;
    claimant.shares = 8;
    Claims one(folder / "claims", claimant);
    one.claim("a");
    one.claim("b");
    const std::vector<ClaimHolder> holders = claim_holders(folder / "claims");
    ASSERT_EQ(holders.size(), 1u);
    EXPECT_TRUE(holders[0].is_alive);
    EXPECT_EQ(holders[0].keys, 2u);
    EXPECT_EQ(holders[0].claimant.share, 3);
    EXPECT_EQ(holders[0].claimant.shares, 8);
    EXPECT_EQ(holders[0].claimant.process, ::getpid());
}

}  // namespace
}  // namespace drover::files::claims_tests
