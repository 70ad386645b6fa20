#include "config/yaml_reader.h"

#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <system_error>
#include <utility>

#include "core/text.h"

namespace vildar {

namespace fs = std::filesystem;

namespace yaml_detail {

/// One map that was read, and the names asked of it.
struct Visit {
  std::string path;
  std::shared_ptr<const YamlNode> node;
  std::set<std::string, std::less<>> asked;
};

struct State {
  fs::path file;
  std::vector<Problem> problems;
  std::size_t problems_left_out = 0;
  std::vector<std::shared_ptr<Visit>> visits;

  void add(Problem problem) {
    constexpr std::size_t kMostProblems = 100;
    if (problems.size() < kMostProblems)
      problems.push_back(std::move(problem));
    else
      ++problems_left_out;
  }
};

}  // namespace yaml_detail

namespace {

using Kind = YamlNode::Kind;
using yaml_detail::State;
using yaml_detail::Visit;

/// A text of the file, fit for one line of a message.
std::string shown(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string out;
  for (const char c : text.substr(0, kLongest))
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  if (text.size() > kLongest) out += "...";
  return out;
}

std::string found_in(const YamlNode& node) {
  switch (node.kind) {
    case Kind::null: return "nothing";
    case Kind::scalar: return '"' + shown(node.scalar) + '"';
    case Kind::list: return "a list of " + std::to_string(node.items.size());
    case Kind::map: return "a map";
  }
  return "nothing";
}

/// The text after a leading plus, which from_chars does not take.
std::string_view without_plus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  return plus ? text.substr(1) : text;
}

template <class Number>
std::errc parse(std::string_view text, Number& value) {
  const std::string_view digits = without_plus(text);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc()) return error;
  return end == digits.data() + digits.size() ? std::errc() : std::errc::invalid_argument;
}

}  // namespace

bool NumberRule::holds(double value) const {
  return std::isfinite(value) && (low_open ? value > low : value >= low) &&
         (high_open ? value < high : value <= high);
}

std::string NumberRule::text() const {
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  std::string text = has_low || has_high ? "must be " : "must be a finite number";
  if (has_low) text += (low_open ? "> " : ">= ") + number_text(low);
  if (has_low && has_high) text += " and ";
  if (has_high) text += (high_open ? "< " : "<= ") + number_text(high);
  if (!unit.empty()) text += ", in " + std::string(unit);
  return text;
}

void YamlItem::problem(std::string fault, std::string remedy) const {
  state_->add({state_->file.string(), line_, path_, std::move(fault), std::move(remedy)});
}

void YamlItem::wrong_kind(std::string_view wanted, std::string remedy) const {
  if (node_->kind == Kind::null)
    problem("has no value", "give " + std::string(wanted) + ", or remove the key");
  else
    problem(found_in(*node_) + " is not " + std::string(wanted), std::move(remedy));
}

bool YamlItem::get(double& target, const NumberRule& rule) const {
  double value = 0.0;
  const std::errc error =
      is_scalar() && !node_->quoted ? parse(node_->scalar, value) : std::errc::invalid_argument;
  if (error == std::errc::result_out_of_range) {
    problem(found_in(*node_) + " is beyond what a number can hold", rule.text());
    return false;
  }
  if (error != std::errc()) {
    wrong_kind("a number",
               node_->quoted ? "write it without quotes" : "write a number such as 1.5");
    return false;
  }
  if (!rule.holds(value)) {
    problem(shown(node_->scalar) + (std::isfinite(value) ? " is out of range" : " is not finite"),
            rule.text());
    return false;
  }
  target = value;
  return true;
}

template <class Integer>
bool YamlItem::get_integer(Integer& target, const NumberRule& rule) const {
  Integer value = 0;
  const std::errc error =
      is_scalar() && !node_->quoted ? parse(node_->scalar, value) : std::errc::invalid_argument;
  if (error == std::errc::invalid_argument) {
    wrong_kind("a whole number", "write a whole number such as 1920");
    return false;
  }
  if (error != std::errc() || !rule.holds(static_cast<double>(value))) {
    problem(shown(node_->scalar) + " is out of range", rule.text());
    return false;
  }
  target = value;
  return true;
}

bool YamlItem::get(int& target, const NumberRule& rule) const { return get_integer(target, rule); }
bool YamlItem::get(std::uint64_t& target, const NumberRule& rule) const {
  return get_integer(target, rule);
}

bool YamlItem::get(bool& target) const {
  const bool truth = is_scalar() && !node_->quoted && node_->scalar == "true";
  if (!truth && !(is_scalar() && !node_->quoted && node_->scalar == "false")) {
    wrong_kind("true or false", "write true or false");
    return false;
  }
  target = truth;
  return true;
}

bool YamlItem::get(std::string& target) const {
  if (!is_scalar() || node_->scalar.empty()) {
    wrong_kind("a name", "write a text that is not empty");
    return false;
  }
  target = node_->scalar;
  return true;
}

bool YamlItem::get(fs::path& target) const {
  std::string text;
  if (!get(text)) return false;
  target = (state_->file.parent_path() / text).lexically_normal();
  return true;
}

bool YamlItem::get(Uncertain& target, const NumberRule& rule) const {
  if (!is_map()) {
    if (!is_scalar()) {
      wrong_kind("a number or {mean: m, std: s}", "write a number or {mean: m, std: s}");
      return false;
    }
    double value = 0.0;
    if (!get(value, rule)) return false;
    target = {value, 0.0};
    return true;
  }
  Uncertain value;
  const std::optional<YamlMap> parts = map();
  const auto mean = parts->find_required("mean");
  const auto std = parts->find_required("std");
  const bool mean_fits = mean && mean->get(value.mean, rule);
  const bool std_fits = std && std->get(value.std, kNotNegative);
  if (!mean_fits || !std_fits) return false;
  target = value;
  return true;
}

std::optional<std::size_t> YamlItem::choice_index(
    const std::vector<std::string_view>& names) const {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (is_scalar() && node_->scalar == names[i]) return i;
    list += (i == 0 ? "" : ", ") + std::string(names[i]);
  }
  const std::string_view near = is_scalar() ? nearest_name(node_->scalar, names) : "";
  const std::string meant =
      near.empty() ? std::string() : "did you mean \"" + std::string(near) + "\"? ";
  wrong_kind("one of the words known here", meant + "must be one of " + list);
  return std::nullopt;
}

std::optional<YamlMap> YamlItem::map() const {
  if (!is_map()) {
    wrong_kind("a map", "write `name: value` pairs");
    return std::nullopt;
  }
  auto visit = std::make_shared<Visit>();
  visit->path = path_;
  visit->node = node_;
  state_->visits.push_back(visit);
  return YamlMap(*this, std::move(visit));
}

std::optional<std::vector<YamlItem>> YamlItem::items() const {
  if (!is_list()) {
    wrong_kind("a list", "write [ ... ], or one line per element beginning with -");
    return std::nullopt;
  }
  std::vector<YamlItem> list;
  for (std::size_t i = 0; i < node_->items.size(); ++i) {
    const auto& node = node_->items[i];
    list.push_back(YamlItem(state_, node, path_ + "[" + std::to_string(i) + "]", node->line));
  }
  return list;
}

bool YamlItem::has_items(std::size_t count) const {
  if (is_list() && node_->items.size() == count) return true;
  wrong_kind("a list of " + std::to_string(count),
             "write exactly " + std::to_string(count) + " values in brackets");
  return false;
}

std::string YamlMap::path_of(std::string_view name) const {
  if (name.empty()) return path();
  return path().empty() ? shown(name) : path() + "." + shown(name);
}

bool YamlMap::has(std::string_view name) const {
  return std::any_of(self_.node_->entries.begin(), self_.node_->entries.end(),
                     [&](const YamlEntry& entry) { return entry.key == name; });
}

std::optional<YamlItem> YamlMap::find(std::string_view name) const {
  visit_->asked.emplace(name);
  for (const YamlEntry& entry : self_.node_->entries)
    if (entry.key == name) return YamlItem(self_.state_, entry.value, path_of(name), entry.line);
  return std::nullopt;
}

std::optional<YamlItem> YamlMap::find_required(std::string_view name) const {
  auto item = find(name);
  if (!item)
    self_.state_->add({self_.state_->file.string(), self_.line_, path_of(name), "is missing",
                       "add it" + (path().empty() ? std::string() : " under " + path())});
  return item;
}

std::optional<YamlMap> YamlMap::map(std::string_view name) const {
  const auto item = find(name);
  return item ? item->map() : std::nullopt;
}

std::optional<YamlMap> YamlMap::require_map(std::string_view name) const {
  const auto item = find_required(name);
  return item ? item->map() : std::nullopt;
}

std::vector<YamlMap> YamlMap::maps(std::string_view name) const {
  std::vector<YamlMap> maps;
  const auto item = find(name);
  if (!item) return maps;
  if (const auto list = item->items())
    for (const YamlItem& element : *list)
      if (auto map = element.map()) maps.push_back(std::move(*map));
  return maps;
}

void YamlMap::problem(std::string_view name, std::string fault, std::string remedy) const {
  int line = self_.line_;
  for (const YamlEntry& entry : self_.node_->entries)
    if (entry.key == name) line = entry.line;
  self_.state_->add(
      {self_.state_->file.string(), line, path_of(name), std::move(fault), std::move(remedy)});
}

void YamlMap::refuse(std::string_view name, std::string fault, std::string remedy) const {
  if (!has(name)) return;
  visit_->asked.emplace(name);
  problem(name, std::move(fault), std::move(remedy));
}

const fs::path& YamlMap::file() const { return self_.state_->file; }
void YamlMap::add(Problem problem) const { self_.state_->add(std::move(problem)); }

namespace {

std::string_view unit_of(std::string_view key) {
  const std::size_t at = key.rfind('_');
  return at == std::string_view::npos ? std::string_view() : key.substr(at + 1);
}

// Who wrote speed_kmh has a value in km/h.
std::string unit_hint(std::string_view written, std::string_view meant) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kUnits{
      {{"mps", "metres per second: km/h divided by 3.6"},
       {"m", "metres"},
       {"s", "seconds"},
       {"deg", "degrees"},
       {"px", "pixels"}}};
  if (unit_of(written) == unit_of(meant)) return "";
  for (const auto& [unit, name] : kUnits)
    if (unit == unit_of(meant)) return " It is in " + std::string(name);
  return "";
}

}  // namespace

YamlReader::YamlReader(const fs::path& file) : YamlReader(parse_yaml_file(file), file) {}

YamlReader::YamlReader(std::string_view text, const fs::path& file)
    : YamlReader(parse_yaml_text(text, file.string()), file) {}

YamlReader::YamlReader(std::shared_ptr<const YamlNode> node, const fs::path& file)
    : state_(std::make_shared<State>()) {
  state_->file = file;
  const int line = node->line;
  root_ = YamlItem(state_, std::move(node), "", line).map();
  if (!root_) finish();
}

std::size_t YamlReader::problem_count() const {
  return state_->problems.size() + state_->problems_left_out;
}

YamlMap YamlReader::root() const { return *root_; }

void YamlReader::finish() const {
  State all = *state_;
  for (const auto& visit : state_->visits) {
    const std::vector<std::string_view> valid(visit->asked.begin(), visit->asked.end());
    std::set<std::string_view> seen;
    for (const YamlEntry& entry : visit->node->entries) {
      const std::string prefix = visit->path.empty() ? "" : visit->path + ".";
      const Problem here{state_->file.string(), entry.line, prefix + shown(entry.key), "", ""};
      if (!seen.insert(entry.key).second) {
        all.add({here.file, here.line, here.key, "stands twice in the same map", "keep one"});
      } else if (!visit->asked.contains(entry.key)) {
        const std::string_view near = nearest_name(entry.key, valid);
        std::string remedy = near.empty() ? "remove it; known here:" : "";
        if (near.empty())
          for (const std::string_view name : valid) remedy += " " + std::string(name);
        else
          remedy = "did you mean \"" + std::string(near) + "\"?" + unit_hint(entry.key, near);
        all.add({here.file, here.line, here.key, "is not a known key", std::move(remedy)});
      }
    }
  }
  if (all.problems.empty()) return;
  std::stable_sort(all.problems.begin(), all.problems.end(),
                   [&](const Problem& a, const Problem& b) {
                     const bool a_here = a.file == all.file, b_here = b.file == all.file;
                     return a_here != b_here ? a_here : a_here && a.line < b.line;
                   });
  if (all.problems_left_out > 0)
    all.problems.push_back({all.file.string(), 0, "",
                            std::to_string(all.problems_left_out) + " more problems follow",
                            "mend those above first"});
  throw ConfigError(std::move(all.problems));
}

}  // namespace vildar
