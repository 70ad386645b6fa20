#pragma once

#include <span>
#include <string>

#include "evaluate/evaluation.h"
#include "evaluate/requirement.h"

namespace vildar {

/// Aligned tables for people, speeds in km/h.
std::string text_report(const Evaluation& evaluation,
                        std::span<const RequirementResult> requirements);

/// One JSON object: matching, vehicles, metrics (the names of --require), withheld_by_reason,
/// methods, requirements, notes. What is not determined is null.
std::string json_report(const Evaluation& evaluation,
                        std::span<const RequirementResult> requirements);

}  // namespace vildar
