#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "evaluate/evaluation.h"

namespace vildar {

/// A number of an evaluation under the name by which `--require` and the JSON know it.
struct NamedMetric {
  std::string name;
  std::optional<double> value;  ///< absent where nothing determines it, e.g. a mean of no errors
};

/// All of them, in the order in which they are shown; those of a method are `METHOD.NAME`.
std::vector<NamedMetric> named_metrics(const Evaluation& evaluation);

/// A bound that a metric must keep, e.g. `recall>=0.95`.
struct Requirement {
  enum class Relation { at_least, at_most, equal, above, below };
  std::string text;
  std::string metric;
  Relation relation = Relation::at_least;
  double bound = 0.0;

  bool holds(double value) const;
};

/// Reads NAME OPERATOR NUMBER with operator >= <= == > <. Throws ConfigError for anything else and
/// for a name that no metric has, with the nearest one.
Requirement parse_requirement(std::string_view text);

struct RequirementResult {
  Requirement requirement;
  std::optional<double> value;
  bool holds = false;  ///< never where the metric has no value
};

/// "recall>=0.95: 0.9", and whether it holds.
std::string to_string(const RequirementResult& result);

std::vector<RequirementResult> check(std::span<const Requirement> requirements,
                                     const Evaluation& evaluation);

}  // namespace vildar
