#include "evaluate/requirement.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/text.h"
#include "types/result.h"

namespace vildar {
namespace {

using Relation = Requirement::Relation;

constexpr std::array<std::pair<std::string_view, Relation>, 5> kRelations{
    {{">=", Relation::at_least},
     {"<=", Relation::at_most},
     {"==", Relation::equal},
     {">", Relation::above},
     {"<", Relation::below}}};

class Metrics {
 public:
  void add(std::string_view name, std::optional<double> value) {
    list_.push_back({prefix_ + std::string(name), value});
  }
  void add(std::string_view name, std::size_t count) {
    add(name, std::optional(static_cast<double>(count)));
  }
  void add_share(std::string_view name, std::size_t part, std::size_t whole) {
    add(name, whole == 0 ? std::nullopt
                         : std::optional(static_cast<double>(part) / static_cast<double>(whole)));
  }
  void add(const SpeedStatistics& speed) {
    add_spread(speed.kmh, "_kmh");
    add_spread(speed.percent, "_percent");
    add("share_within_limits", speed.share_within_limits);
    add("coverage", speed.coverage);
    add("z_rms", speed.z_rms);
  }
  void add(const std::optional<TrackingScores>& tracking) {
    const auto value = [&](auto&& of) {
      return tracking ? std::optional<double>(of(*tracking)) : std::nullopt;
    };
    using Scores = TrackingScores;
    add("hota", value([](const Scores& s) { return mean_of(s.hota.hota()); }));
    add("deta", value([](const Scores& s) { return mean_of(s.hota.detection_accuracy()); }));
    add("assa", value([](const Scores& s) { return mean_of(s.hota.association_accuracy); }));
    add("loca", value([](const Scores& s) { return mean_of(s.hota.localisation); }));
    add("mota", value([](const Scores& s) { return s.clear.mota(); }));
    add("motp", value([](const Scores& s) { return s.clear.motp(); }));
    add("idf1", value([](const Scores& s) { return s.identity.idf1(); }));
    add("id_switches",
        value([](const Scores& s) { return static_cast<double>(s.clear.id_switches); }));
    add("fragmentations",
        value([](const Scores& s) { return static_cast<double>(s.clear.fragmentations); }));
  }
  void set_prefix(std::string prefix) { prefix_ = std::move(prefix); }
  std::vector<NamedMetric> take() { return std::move(list_); }

 private:
  void add_spread(const ErrorSpread& spread, std::string_view unit) {
    add("mean_abs_error" + std::string(unit), spread.mean_abs);
    add("median_abs_error" + std::string(unit), spread.median_abs);
    add("p95_abs_error" + std::string(unit), spread.p95_abs);
    add("max_error" + std::string(unit), spread.max);
    add("bias" + std::string(unit), spread.bias);
  }

  std::string prefix_;
  std::vector<NamedMetric> list_;
};

std::size_t total(const std::map<std::string, std::size_t>& by_reason) {
  std::size_t sum = 0;
  for (const auto& [reason, count] : by_reason) sum += count;
  return sum;
}

[[noreturn]] void refuse(std::string_view text, std::string fault, std::string remedy) {
  throw ConfigError({Problem{"--require \"" + std::string(text) + "\"", 0, "", std::move(fault),
                             std::move(remedy)}});
}

void check_name(std::string_view text, const std::string& metric) {
  std::vector<NamedMetric> known;
  {
    Evaluation all;
    for (int method = 0; method <= static_cast<int>(Method::fused); ++method)
      all.methods[std::string(name_of(static_cast<Method>(method)))];
    known = named_metrics(all);
  }
  if (std::ranges::find(known, metric, &NamedMetric::name) != known.end()) return;
  std::vector<std::string_view> names;
  for (const NamedMetric& one : known) names.push_back(one.name);
  const std::string_view nearest = nearest_name(metric, names);
  std::string remedy = "the names are those under \"metrics\" in the output of --json";
  if (!nearest.empty()) remedy = "did you mean \"" + std::string(nearest) + "\"?";
  refuse(text, "no metric is called \"" + metric + "\"", remedy);
}

}  // namespace

std::vector<NamedMetric> named_metrics(const Evaluation& evaluation) {
  Metrics metrics;
  metrics.add_share("recall", evaluation.measured, evaluation.in_view);
  metrics.add_share("precision", evaluation.measured,
                    evaluation.measured + evaluation.false_speeds);
  metrics.add_share("detection_recall", evaluation.matched, evaluation.in_view);
  metrics.add("vehicles", evaluation.in_view);
  metrics.add("not_in_view", evaluation.not_in_view);
  metrics.add("matched", evaluation.matched);
  metrics.add("measured", evaluation.measured);
  metrics.add("withheld", total(evaluation.withheld));
  metrics.add("missed", evaluation.missed);
  metrics.add("false", evaluation.false_speeds);
  metrics.add("duplicates", evaluation.duplicates);
  metrics.add("wrong_direction", evaluation.wrong_direction);
  metrics.add("without_truth", evaluation.without_truth);
  metrics.add(evaluation.speed);
  metrics.add("azimuth_rms_rad", evaluation.azimuth_rms_rad);
  metrics.add("range_rms_m", evaluation.range_rms_m);
  metrics.add(evaluation.tracking);
  for (const auto& [name, method] : evaluation.methods) {
    metrics.set_prefix(name + ".");
    metrics.add("measured", method.measured);
    metrics.add("withheld", total(method.withheld));
    metrics.add("false", method.false_speeds);
    metrics.add(method.speed);
  }
  return metrics.take();
}

bool Requirement::holds(double value) const {
  switch (relation) {
    case Relation::at_least: return value >= bound;
    case Relation::at_most: return value <= bound;
    case Relation::equal: return value == bound;
    case Relation::above: return value > bound;
    case Relation::below: return value < bound;
  }
  return false;
}

Requirement parse_requirement(std::string_view text) {
  const std::size_t at = text.find_first_of("<>=");
  for (const auto& [sign, relation] : kRelations) {
    if (at == std::string_view::npos || !text.substr(at).starts_with(sign)) continue;
    Requirement requirement{std::string(text), std::string(trimmed(text.substr(0, at))), relation,
                            0.0};
    const std::string_view number = trimmed(text.substr(at + sign.size()));
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), requirement.bound);
    if (error != std::errc() || end != number.data() + number.size() ||
        !std::isfinite(requirement.bound))
      refuse(text, "\"" + std::string(number) + "\" is not a finite number",
             "write it as in recall>=0.95");
    check_name(text, requirement.metric);
    return requirement;
  }
  refuse(text, "has none of the operators >= <= == > <", "write it as in recall>=0.95");
}

std::string to_string(const RequirementResult& result) {
  std::string text = result.requirement.text + ": ";
  if (!result.value) return text + "does not hold, because there is nothing to compute it from";
  return text + (result.holds ? "holds, it is " : "does not hold, it is ") +
         number_text(*result.value);
}

std::vector<RequirementResult> check(std::span<const Requirement> requirements,
                                     const Evaluation& evaluation) {
  const std::vector<NamedMetric> metrics = named_metrics(evaluation);
  std::vector<RequirementResult> results;
  for (const Requirement& requirement : requirements) {
    RequirementResult result{requirement, std::nullopt, false};
    // A method that the run never tried has no row among the metrics, and so no value.
    const auto found = std::ranges::find(metrics, requirement.metric, &NamedMetric::name);
    if (found != metrics.end()) result.value = found->value;
    result.holds = result.value && requirement.holds(*result.value);
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace vildar
