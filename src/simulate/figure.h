#pragma once

#include <optional>
#include <string>
#include <vector>

namespace vildar::simulate {

struct Series {
  std::string label;
  std::vector<double> x, y;  ///< a y that is not finite leaves a gap
  int colour = 0;
  bool dashed = false;
  bool dots = false;  ///< points in place of a line
};

/// One plot and the numbers behind it.
struct Figure {
  std::string name;  ///< of its files, without an ending
  std::string title;
  std::string caption;             ///< what it shows, and the reading that it uses
  std::string x_title, y_title;    ///< with units, for people
  std::string x_column, y_column;  ///< with units, for the CSV
  std::vector<Series> series;
  std::optional<double> y_low, y_high;
  bool log_y = false;
};

struct Table {
  std::string name;
  std::string title;
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// A number that the paper, or a claim of it, can be checked by.
struct Finding {
  std::string what;
  double value = 0.0;
  std::string unit;
};

struct Report {
  std::string experiment;
  std::vector<Figure> figures;
  std::vector<Table> tables;
  std::vector<Finding> findings;
};

std::string csv_of(const Figure& figure);
std::string csv_of(const Table& table);
/// A whole SVG drawing with axes, units and a legend.
std::string svg_of(const Figure& figure);
/// One self-contained page with every figure, table and number.
std::string page_of(const std::vector<Report>& reports, const std::string& settings);

}  // namespace vildar::simulate
