#include "core/text.h"
#include "simulate/figure.h"

namespace vildar::simulate {
namespace {

constexpr const char* kHead =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
    "<meta name=\"viewport\" content=\"width=device-width\"><title>vildar: the paper's "
    "experiments</title>\n<style>body{font:15px/1.5 Helvetica,Arial,sans-serif;max-width:960px;"
    "margin:2em auto;padding:0 1em;color:#222}figure{margin:1.5em 0}svg{width:100%;height:auto;"
    "border:1px solid #ddd}figcaption{color:#444}table{border-collapse:collapse;margin:1em 0}"
    "td,th{border:1px solid #ccc;padding:.25em .6em;text-align:right}td:first-child,"
    "th:first-child{text-align:left}h2{margin-top:2.5em;border-bottom:1px solid #ccc}"
    "pre{background:#f5f5f5;padding:.8em;overflow:auto}</style></head><body>\n"
    "<h1>Speed from headlamp light: the published experiments again</h1>\n";

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return safe;
}

std::string table_of(const std::vector<std::string>& header,
                     const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<table><tr>";
  for (const std::string& cell : header) html += "<th>" + escaped(cell) + "</th>";
  html += "</tr>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + escaped(cell) + "</td>";
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

}  // namespace

std::string page_of(const std::vector<Report>& reports, const std::string& settings) {
  std::string html = kHead;
  html += "<p>";
  for (const Report& report : reports)
    html += "<a href=\"#" + report.experiment + "\">" + report.experiment + "</a> ";
  html += "</p>\n";
  for (const Report& report : reports) {
    html += "<h2 id=\"" + report.experiment + "\">" + report.experiment + "</h2>\n";
    for (const Figure& figure : report.figures)
      html += "<figure>" + svg_of(figure) + "<figcaption>" + escaped(figure.caption) +
              " (<a href=\"" + figure.name + ".csv\">numbers</a>)</figcaption></figure>\n";
    for (const Table& table : report.tables)
      html += "<h3>" + escaped(table.title) + "</h3>\n<p>" + escaped(table.caption) + "</p>\n" +
              table_of(table.header, table.rows);
    std::vector<std::vector<std::string>> rows;
    for (const Finding& finding : report.findings)
      rows.push_back({finding.what, fixed_text(finding.value, 3), finding.unit});
    if (!rows.empty()) html += table_of({"number", "value", "unit"}, rows);
  }
  return html + "<h2>Settings</h2>\n<pre>" + escaped(settings) + "</pre>\n</body></html>\n";
}

}  // namespace vildar::simulate
