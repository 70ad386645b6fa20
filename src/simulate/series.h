#pragma once

#include <string>
#include <vector>

#include "core/text.h"
#include "simulate/figure.h"
#include "simulate/options.h"
#include "simulate/pass.h"

namespace vildar::simulate {

/// One entry of a legend: a pass and the number that sets it apart.
struct Case {
  std::string label;
  Pass pass;
};

/// Scores of the cases, each with random numbers of its own; `family` tells experiments apart.
std::vector<PassScores> score_cases(const std::vector<Case>& cases, const Options& options,
                                    std::uint64_t family);

enum class Against { incidence, time };
/// Accuracy of the paper's estimator (solid) and of maximum likelihood (dashed).
Figure accuracy_figure(const std::vector<Case>& cases, const std::vector<PassScores>& scores,
                       Against against);
/// Root mean square errors of both, and the Cramer-Rao bound, on a logarithmic scale.
Figure error_figure(const std::vector<Case>& cases, const std::vector<PassScores>& scores,
                    Against against);

/// The readings of the generator that the options ask for.
std::vector<bool> cosine_readings(const Options& options);
/// "with-cosine" or "no-cosine", for file names.
std::string cosine_tag(bool cosine);
/// "with the cosine" or "without the cosine", for titles.
std::string cosine_title(bool cosine);
std::string cosine_words(bool cosine);

}  // namespace vildar::simulate
