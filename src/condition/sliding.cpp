#include "condition/sliding.h"

#include <deque>
#include <functional>

namespace vildar {
namespace {

template <class Before>
std::vector<double> sliding(const std::vector<double>& times_s, const std::vector<double>& values,
                            double reach_s, Before before) {
  std::vector<double> found(values.size());
  std::deque<std::size_t> candidates;  // each beaten by all earlier ones, none later than it beats
  std::size_t next = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (; next < values.size() && times_s[next] <= times_s[i] + reach_s; ++next) {
      while (!candidates.empty() && !before(values[candidates.back()], values[next]))
        candidates.pop_back();
      candidates.push_back(next);
    }
    while (times_s[candidates.front()] < times_s[i] - reach_s) candidates.pop_front();
    found[i] = values[candidates.front()];
  }
  return found;
}

}  // namespace

std::vector<double> sliding_minimum(const std::vector<double>& times_s,
                                    const std::vector<double>& values, double reach_s) {
  return sliding(times_s, values, reach_s, std::less<>());
}

std::vector<double> sliding_maximum(const std::vector<double>& times_s,
                                    const std::vector<double>& values, double reach_s) {
  return sliding(times_s, values, reach_s, std::greater<>());
}

}  // namespace vildar
