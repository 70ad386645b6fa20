#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/text.h"
#include "sink/html.h"
#include "sink/report_parts.h"

namespace vildar {
namespace {

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string two_columns(const std::string& rows) {
  return "<table><tbody>" + rows + "</tbody></table>";
}

std::string named(const std::string& name, const std::string& value) {
  return "<tr><td>" + escaped(name) + "</td><td class=\"number\">" + escaped(value) + "</td></tr>";
}

std::string inputs_table(const std::vector<InputFile>& inputs) {
  std::string html =
      "<div class=\"scroll\"><table class=\"cards\"><thead><tr><th>Input</th><th>File</th><th "
      "class=\"number\">Bytes</th>"
      "<th>SHA-256</th></tr></thead><tbody>";
  for (const InputFile& input : inputs)
    html += "<tr><td data-label=\"Input\">" + escaped(input.role) +
            "</td><td data-label=\"File\"><code>" + escaped(input.path.string()) +
            "</code></td><td class=\"number\" data-label=\"Bytes\">" +
            std::to_string(input.size_bytes) + "</td><td data-label=\"SHA-256\"><code>" +
            escaped(input.sha256) + "</code></td></tr>";
  return html + "</tbody></table></div>";
}

std::string block(const std::string& title, const std::string& rows) {
  return rows.empty() ? "" : "<div><h3>" + escaped(title) + "</h3>" + two_columns(rows) + "</div>";
}

std::string watts(double power_w) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g W", power_w);
  return text.data();
}

std::string light_rows(const TraceSummary& trace) {
  std::string rows = named("samples a second", number_text(std::round(trace.sample_rate_hz))) +
                     named("noise of a sample", watts(trace.noise_w)) +
                     named("ambient", watts(trace.ambient_w));
  if (trace.drift_w > 0.0) rows += named("change of the ambient", watts(trace.drift_w));
  if (trace.switched_w > 0.0)
    rows += named("lights switched on and off", "up to " + watts(trace.switched_w));
  if (trace.mains_hz > 0.0)
    rows +=
        named("flicker of " + fixed_text(trace.mains_hz, 2) + " Hz mains", watts(trace.flicker_w));
  if (!trace.pulsing.empty())
    rows +=
        named("stretches of pulsing light", number_text(static_cast<double>(trace.pulsing.size())));
  return rows;
}

}  // namespace

std::string report_making(const RunSummary& summary) {
  std::string html = "<h2>How it was made</h2>";
  if (!summary.inputs.empty()) html += inputs_table(summary.inputs);
  std::string counts, timings, options;
  for (const auto& [name, count] : summary.counts)
    counts += named(spaced(name), std::to_string(count));
  for (const auto& [stage, time_s] : summary.timings_s)
    timings += named(spaced(stage), fixed_text(time_s, 2) + " s");
  for (const auto& [name, value] : summary.options) options += named(name, value);
  html += "<div class=\"columns\">" + block("Counts", counts);
  for (const auto& [photodiode, reasons] : summary.rejected_samples) {
    std::string rows;
    for (const auto& [reason, count] : reasons)
      rows += named(spaced(reason), std::to_string(count));
    html += block("Samples left out" + (photodiode.empty() ? "" : ", " + photodiode), rows);
  }
  for (const TraceSummary& trace : summary.traces)
    html += block("Light on " + trace.photodiode, light_rows(trace));
  html += block("CPU time", timings) + block("Options", options) + "</div>";
  if (!summary.settings_yaml.empty())
    html += "<details><summary>Site file in force</summary><div class=\"inside\"><pre>" +
            escaped(summary.settings_yaml) + "</pre></div></details>";
  return html;
}

}  // namespace vildar
