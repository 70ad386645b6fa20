#include "simulate/monte_carlo.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace vildar::simulate {

void for_each_trial(int trials, int threads, const std::function<void(int)>& trial) {
  const int machine = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int count = std::clamp(threads > 0 ? threads : machine, 1, std::max(1, trials));
  std::atomic<int> next{0};
  std::mutex guard;
  std::exception_ptr failure;
  const auto work = [&] {
    for (int index = next++; index < trials; index = next++) {
      try {
        trial(index);
      } catch (const std::exception&) {
        const std::lock_guard lock(guard);
        if (!failure) failure = std::current_exception();
        next = trials;
      }
    }
  };
  {
    std::vector<std::jthread> pool;
    for (int i = 1; i < count; ++i) pool.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

std::uint64_t trial_seed(std::uint64_t seed, std::uint64_t stream, int trial) {
  // Steele, Lea and Flood's splitmix64: neighbouring inputs give unrelated outputs.
  std::uint64_t state = seed * 0x9e3779b97f4a7c15ull + stream * 0xd1b54a32d192ed03ull +
                        static_cast<std::uint64_t>(trial);
  for (int round = 0; round < 2; ++round) {
    state += 0x9e3779b97f4a7c15ull;
    state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9ull;
    state = (state ^ (state >> 27)) * 0x94d049bb133111ebull;
    state ^= state >> 31;
  }
  return state;
}

}  // namespace vildar::simulate
