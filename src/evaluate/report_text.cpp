#include <algorithm>
#include <cmath>
#include <vector>

#include "core/quantity.h"
#include "core/text.h"
#include "evaluate/report.h"

namespace vildar {
namespace {

// Columns as wide as their widest cell; text to the left, numbers to the right.
class Table {
 public:
  explicit Table(std::vector<std::string> header) { rows_.push_back(std::move(header)); }
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::size_t rows() const { return rows_.size() - 1; }

  std::string text(std::size_t left_columns) const {
    std::string text;
    for (const std::vector<std::string>& row : rows_) {
      std::string line;
      for (std::size_t column = 0; column < row.size(); ++column) {
        std::size_t width = 0;
        for (const auto& other : rows_) width = std::max(width, other[column].size());
        const std::string space(width - row[column].size(), ' ');
        if (column > 0) line += "  ";
        line += column < left_columns ? row[column] + space : space + row[column];
      }
      line.erase(line.find_last_not_of(' ') + 1);
      text += line + "\n";
    }
    return text;
  }

 private:
  std::vector<std::vector<std::string>> rows_;
};

std::string cell(std::optional<double> value, int digits) {
  return value ? fixed_text(*value, digits) : "-";
}

std::string signed_cell(std::optional<double> value, int digits) {
  return value && *value >= 0.0 ? "+" + fixed_text(*value, digits) : cell(value, digits);
}

std::string share_cell(std::optional<double> share) {
  return share ? fixed_text(100.0 * *share, 1) + " %" : "-";
}

std::string text_cell(const std::string& text) { return text.empty() ? "-" : text; }

std::string outcome_cell(const VehicleScore& vehicle) {
  std::string text(name_of(vehicle.outcome));
  if (vehicle.outcome == VehicleScore::Outcome::not_in_view) text = "not in view";
  if (!vehicle.withheld.empty()) text += ": " + vehicle.withheld;
  if (vehicle.wrong_direction) text += ", wrong direction";
  return text;
}

std::string vehicles_text(const Evaluation& evaluation) {
  Table table({"vehicle", "track", "lane", "outcome", "t_ref s", "true km/h", "run km/h",
               "error km/h", "error %", "z", "in 95 %", "azimuth mrad", "range m"});
  for (const VehicleScore& vehicle : evaluation.vehicles) {
    const std::optional<SpeedPair> pair = vehicle.pair();
    std::optional<double> t_s, run_kmh, true_kmh, error_kmh, percent, z, azimuth_mrad;
    std::string inside = "-";
    if (vehicle.stated) {
      t_s = vehicle.stated->t_ref_s;
      run_kmh = kmh_from_mps(vehicle.stated->speed_mps);
    }
    if (pair) {
      true_kmh = kmh_from_mps(pair->true_mps);
      error_kmh = kmh_from_mps(pair->error_mps());
      percent = pair->error_percent();
      z = pair->z();
      if (const auto value = pair->inside_95()) inside = *value ? "yes" : "no";
    }
    if (vehicle.azimuth_rms_rad) azimuth_mrad = 1e3 * *vehicle.azimuth_rms_rad;
    table.add({text_cell(vehicle.vehicle_id), text_cell(vehicle.track_id), text_cell(vehicle.lane),
               outcome_cell(vehicle), cell(t_s, 3), cell(true_kmh, 2), cell(run_kmh, 2),
               signed_cell(error_kmh, 2), signed_cell(percent, 2), signed_cell(z, 2), inside,
               cell(azimuth_mrad, 2), cell(vehicle.range_rms_m, 2)});
  }
  return table.rows() > 0 ? table.text(4) : "neither truth nor run has a vehicle\n";
}

std::vector<std::string> speed_cells(const SpeedStatistics& speed) {
  return {std::to_string(speed.count),        signed_cell(speed.kmh.bias, 2),
          cell(speed.kmh.mean_abs, 2),        cell(speed.kmh.median_abs, 2),
          cell(speed.kmh.p95_abs, 2),         cell(speed.kmh.max, 2),
          signed_cell(speed.percent.bias, 2), cell(speed.percent.mean_abs, 2),
          cell(speed.percent.max, 2),         share_cell(speed.share_within_limits),
          share_cell(speed.coverage),         cell(speed.z_rms, 2)};
}

std::string reasons_text(const std::map<std::string, std::size_t>& by_reason) {
  std::string text;
  for (const auto& [reason, count] : by_reason)
    text += (text.empty() ? "" : ", ") + reason + " " + std::to_string(count);
  return text.empty() ? "-" : text;
}

std::string speeds_text(const Evaluation& evaluation) {
  Table table({"speed", "compared", "bias km/h", "mean", "median", "95 %", "max", "bias %",
               "mean %", "max %", "within 3", "in 95 %", "z rms", "false", "withheld"});
  const auto add = [&](std::string name, const SpeedStatistics& speed, std::size_t false_speeds,
                       const std::map<std::string, std::size_t>& withheld) {
    std::vector<std::string> row{std::move(name)};
    std::ranges::move(speed_cells(speed), std::back_inserter(row));
    row.push_back(std::to_string(false_speeds));
    row.push_back(reasons_text(withheld));
    table.add(std::move(row));
  };
  add("speeds.csv", evaluation.speed, evaluation.false_speeds, evaluation.withheld);
  for (const auto& [name, method] : evaluation.methods)
    add(name, method.speed, method.false_speeds, method.withheld);
  return table.text(1) +
         "errors: mean, median, 95th percentile and maximum of the absolute; within 3: share off "
         "by "
         "at most 3 km/h up to 100 km/h, 3 % above\n";
}

std::string counts_text(const Evaluation& evaluation) {
  std::size_t withheld = 0;
  for (const auto& [reason, count] : evaluation.withheld) withheld += count;
  Table table({"vehicles", "matched", "measured", "withheld", "missed", "false", "duplicates",
               "wrong direction", "not in view", "recall", "precision", "azimuth mrad", "range m"});
  const std::vector<NamedMetric> metrics = named_metrics(evaluation);
  const auto metric = [&](std::string_view name) {
    return std::ranges::find(metrics, name, &NamedMetric::name)->value;
  };
  std::optional<double> azimuth_mrad;
  if (evaluation.azimuth_rms_rad) azimuth_mrad = 1e3 * *evaluation.azimuth_rms_rad;
  table.add({std::to_string(evaluation.in_view), std::to_string(evaluation.matched),
             std::to_string(evaluation.measured), std::to_string(withheld),
             std::to_string(evaluation.missed), std::to_string(evaluation.false_speeds),
             std::to_string(evaluation.duplicates), std::to_string(evaluation.wrong_direction),
             std::to_string(evaluation.not_in_view), share_cell(metric("recall")),
             share_cell(metric("precision")), cell(azimuth_mrad, 2),
             cell(evaluation.range_rms_m, 2)});
  return table.text(0);
}

std::string tracking_text(const TrackingScores& scores) {
  Table table({"HOTA", "DetA", "AssA", "LocA", "MOTA", "MOTP", "IDF1", "ID switches"});
  table.add({fixed_text(mean_of(scores.hota.hota()), 4),
             fixed_text(mean_of(scores.hota.detection_accuracy()), 4),
             fixed_text(mean_of(scores.hota.association_accuracy), 4),
             fixed_text(mean_of(scores.hota.localisation), 4), fixed_text(scores.clear.mota(), 4),
             fixed_text(scores.clear.motp(), 4), fixed_text(scores.identity.idf1(), 4),
             std::to_string(scores.clear.id_switches)});
  return table.text(0);
}

}  // namespace

std::string text_report(const Evaluation& evaluation,
                        std::span<const RequirementResult> requirements) {
  std::string text =
      vehicles_text(evaluation) + "\n" + counts_text(evaluation) + "\n" + speeds_text(evaluation);
  if (evaluation.tracking) text += "\n" + tracking_text(*evaluation.tracking);
  text += evaluation.matched_by_image ? "\nmatched by image position\n" : "\nmatched by time\n";
  for (const std::string& note : evaluation.notes) text += "note: " + note + "\n";
  for (const RequirementResult& result : requirements) text += to_string(result) + "\n";
  return text;
}

}  // namespace vildar
