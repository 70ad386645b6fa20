#include "core/assignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace vildar {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

// Shortest augmenting paths with dual potentials (Kuhn; Jonker and Volgenant 1987), for the side
// with fewer members as agents.
class Solver {
 public:
  Solver(std::span<const double> cost, std::size_t rows, std::size_t columns)
      : cost_(cost),
        columns_(columns),
        transposed_(rows > columns),
        agents_(std::min(rows, columns)),
        jobs_(std::max(rows, columns)),
        agent_price_(agents_, 0.0),
        job_price_(jobs_, 0.0),
        agent_of_job_(jobs_, kNone),
        distance_(jobs_),
        job_before_(jobs_),
        reached_(jobs_) {}

  std::vector<AssignedPair> solve() {
    for (std::size_t agent = 0; agent < agents_; ++agent) place(agent);
    std::vector<AssignedPair> pairs;
    pairs.reserve(agents_);
    for (std::size_t job = 0; job < jobs_; ++job) {
      if (agent_of_job_[job] == kNone) continue;
      pairs.push_back(transposed_ ? AssignedPair{job, agent_of_job_[job]}
                                  : AssignedPair{agent_of_job_[job], job});
    }
    std::ranges::sort(pairs, {}, &AssignedPair::row);
    return pairs;
  }

 private:
  double cost(std::size_t agent, std::size_t job) const {
    return transposed_ ? cost_[job * columns_ + agent] : cost_[agent * columns_ + job];
  }

  // Dijkstra over reduced costs from the new agent to the nearest free job, then the swap along the
  // path found.
  void place(std::size_t new_agent) {
    std::ranges::fill(distance_, std::numeric_limits<double>::infinity());
    std::ranges::fill(job_before_, kNone);
    reached_.assign(jobs_, false);
    std::size_t agent = new_agent;
    std::size_t job_at = kNone;
    double length = 0.0;
    while (true) {
      std::size_t nearest = kNone;
      for (std::size_t job = 0; job < jobs_; ++job) {
        if (reached_[job]) continue;
        const double through = length + cost(agent, job) - agent_price_[agent] - job_price_[job];
        if (through < distance_[job]) {
          distance_[job] = through;
          job_before_[job] = job_at;
        }
        if (nearest == kNone || distance_[job] < distance_[nearest]) nearest = job;
      }
      length = distance_[nearest];
      reached_[nearest] = true;
      job_at = nearest;
      if (agent_of_job_[nearest] == kNone) break;
      agent = agent_of_job_[nearest];
    }
    agent_price_[new_agent] += length;
    for (std::size_t job = 0; job < jobs_; ++job) {
      if (!reached_[job] || job == job_at) continue;
      agent_price_[agent_of_job_[job]] += length - distance_[job];
      job_price_[job] -= length - distance_[job];
    }
    while (job_before_[job_at] != kNone) {
      agent_of_job_[job_at] = agent_of_job_[job_before_[job_at]];
      job_at = job_before_[job_at];
    }
    agent_of_job_[job_at] = new_agent;
  }

  std::span<const double> cost_;
  std::size_t columns_;
  bool transposed_;
  std::size_t agents_, jobs_;
  std::vector<double> agent_price_, job_price_;
  std::vector<std::size_t> agent_of_job_;
  std::vector<double> distance_;
  std::vector<std::size_t> job_before_;
  std::vector<bool> reached_;
};

}  // namespace

std::vector<AssignedPair> assign(std::span<const double> cost, std::size_t rows,
                                 std::size_t columns) {
  if (cost.size() != rows * columns)
    throw std::invalid_argument("assign: " + std::to_string(cost.size()) + " costs for " +
                                std::to_string(rows) + " x " + std::to_string(columns));
  if (!std::ranges::all_of(cost, [](double value) { return std::isfinite(value); }))
    throw std::invalid_argument("assign: every cost must be finite");
  if (cost.empty()) return {};
  return Solver(cost, rows, columns).solve();
}

}  // namespace vildar
