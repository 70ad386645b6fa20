#include "core/text.h"
#include "simulate/figure.h"

namespace vildar::simulate {
namespace {

std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

std::string line(const std::vector<std::string>& cells) {
  std::string text;
  for (std::size_t i = 0; i < cells.size(); ++i) text += (i > 0 ? "," : "") + cell(cells[i]);
  return text + '\n';
}

}  // namespace

std::string csv_of(const Figure& figure) {
  std::string text = line({"series", figure.x_column, figure.y_column});
  for (const Series& series : figure.series)
    for (std::size_t i = 0; i < series.x.size(); ++i)
      text += line({series.label, number_text(series.x[i]), number_text(series.y[i])});
  return text;
}

std::string csv_of(const Table& table) {
  std::string text = line(table.header);
  for (const auto& row : table.rows) text += line(row);
  return text;
}

}  // namespace vildar::simulate
