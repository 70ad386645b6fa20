#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/yaml_document.h"
#include "core/error.h"
#include "core/quantity.h"
#include "types/site.h"

namespace vildar {

/// The finite numbers that a key may hold. NaN and infinities never hold.
struct NumberRule {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;       ///< low itself is outside
  bool high_open = false;      ///< high itself is outside
  std::string_view unit = {};  ///< of both, where a number in another one is a likely mistake

  bool holds(double value) const;
  std::string text() const;  ///< "must be > 0", "must be >= 0.1 and <= 3, in metres"
};
inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();
inline constexpr NumberRule kAnyNumber{};
inline constexpr NumberRule kPositive{0.0, kUnbounded, true, false};
inline constexpr NumberRule kNotNegative{0.0, kUnbounded, false, false};

/// A word of the file and what it means; lists of them are std::array<Choice<E>, N>.
template <class E>
struct Choice {
  std::string_view name;
  E value;
};

namespace yaml_detail {
struct State;
struct Visit;
}  // namespace yaml_detail
class YamlMap;

/// One value with the path that leads to it. Each get() leaves `target` as it is and notes a
/// problem where the value does not fit; the return value says whether it fitted.
class YamlItem {
 public:
  bool get(double& target, const NumberRule& rule = kAnyNumber) const;
  bool get(int& target, const NumberRule& rule = kAnyNumber) const;
  bool get(std::uint64_t& target, const NumberRule& rule = kAnyNumber) const;
  bool get(bool& target) const;
  /// Not empty.
  bool get(std::string& target) const;
  /// Relative paths are taken from the folder of the YAML file.
  bool get(std::filesystem::path& target) const;
  /// A number, or {mean, std} with std >= 0; the rule binds the mean.
  bool get(Uncertain& target, const NumberRule& rule = kAnyNumber) const;

  template <class E, std::size_t N>
  bool get(E& target, const std::array<Choice<E>, N>& choices) const {
    std::array<std::string_view, N> names;
    for (std::size_t i = 0; i < N; ++i) names[i] = choices[i].name;
    const std::optional<std::size_t> index = choice_index(names);
    if (index) target = choices[*index].value;
    return index.has_value();
  }
  template <class T, class... Rule>
  bool get(std::optional<T>& target, const Rule&... rule) const {
    T value{};
    if (!get(value, rule...)) return false;
    target = value;
    return true;
  }
  /// A list of exactly N values.
  template <class T, std::size_t N, class... Rule>
  bool get(std::array<T, N>& target, const Rule&... rule) const {
    std::vector<T> values;
    if (!has_items(N) || !get(values, rule...)) return false;
    std::copy(values.begin(), values.end(), target.begin());
    return true;
  }
  /// A list of any length.
  template <class T, class... Rule>
  bool get(std::vector<T>& target, const Rule&... rule) const {
    const std::optional<std::vector<YamlItem>> list = items();
    if (!list) return false;
    std::vector<T> values(list->size());
    bool fits = true;
    for (std::size_t i = 0; i < values.size(); ++i)
      fits = (*list)[i].get(values[i], rule...) && fits;
    if (fits) target = std::move(values);
    return fits;
  }

  bool is_scalar() const { return node_->kind == YamlNode::Kind::scalar; }
  bool is_map() const { return node_->kind == YamlNode::Kind::map; }
  bool is_list() const { return node_->kind == YamlNode::Kind::list; }
  std::optional<YamlMap> map() const;
  /// Notes a problem unless the value is a list.
  std::optional<std::vector<YamlItem>> items() const;
  void problem(std::string fault, std::string remedy) const;

 private:
  friend class YamlMap;
  friend class YamlReader;
  YamlItem(std::shared_ptr<yaml_detail::State> state, std::shared_ptr<const YamlNode> node,
           std::string path, int line)
      : state_(std::move(state)), node_(std::move(node)), path_(std::move(path)), line_(line) {}
  bool has_items(std::size_t count) const;
  std::optional<std::size_t> choice_index(const std::vector<std::string_view>& names) const;
  template <std::size_t N>
  std::optional<std::size_t> choice_index(const std::array<std::string_view, N>& names) const {
    return choice_index(std::vector<std::string_view>(names.begin(), names.end()));
  }
  template <class Integer>
  bool get_integer(Integer& target, const NumberRule& rule) const;
  void wrong_kind(std::string_view wanted, std::string remedy) const;

  std::shared_ptr<yaml_detail::State> state_;
  std::shared_ptr<const YamlNode> node_;
  std::string path_;
  int line_ = 0;
};

/// A map of the file. A cheap handle; copies share what has been read. Every name asked for counts
/// as a valid key of this map, and keys that nobody asked for are reported by YamlReader::finish().
class YamlMap {
 public:
  /// Whether the key is present; does not count as reading it.
  bool has(std::string_view name) const;

  /// An optional key: `target` stays as it is where the key is absent. True where a value was read.
  template <class T, class... Rule>
  bool read(std::string_view name, T& target, const Rule&... rule) const {
    const auto item = find(name);
    return item && item->get(target, rule...);
  }
  /// A required key: its absence is a problem at the line of this map.
  template <class T, class... Rule>
  bool require(std::string_view name, T& target, const Rule&... rule) const {
    const auto item = find_required(name);
    return item && item->get(target, rule...);
  }
  /// As read() and require(); the rule is in degrees, the target (a number, Uncertain, or optional
  /// of these) in radians.
  template <class T>
  void read_degrees(std::string_view name, T& target_rad,
                    const NumberRule& rule = kAnyNumber) const {
    if (const auto item = find(name)) get_degrees(*item, target_rad, rule);
  }
  template <class T>
  void require_degrees(std::string_view name, T& target_rad,
                       const NumberRule& rule = kAnyNumber) const {
    if (const auto item = find_required(name)) get_degrees(*item, target_rad, rule);
  }

  std::optional<YamlMap> map(std::string_view name) const;
  std::optional<YamlMap> require_map(std::string_view name) const;
  /// A list of maps; empty where absent. Elements that are not maps are problems and left out.
  std::vector<YamlMap> maps(std::string_view name) const;

  std::optional<YamlItem> find(std::string_view name) const;
  std::optional<YamlItem> find_required(std::string_view name) const;

  /// Notes a problem of a key (at the line of the map where the key is absent), or of the map
  /// itself where `name` is empty.
  void problem(std::string_view name, std::string fault, std::string remedy) const;
  /// The key has no place here, given the other keys: notes the problem where it is present.
  void refuse(std::string_view name, std::string fault, std::string remedy) const;

  const std::string& path() const { return self_.path_; }
  /// The YAML file this map stands in.
  const std::filesystem::path& file() const;
  /// Notes a problem of another file that this one names.
  void add(Problem problem) const;

 private:
  friend class YamlItem;
  YamlMap(YamlItem self, std::shared_ptr<yaml_detail::Visit> visit)
      : self_(std::move(self)), visit_(std::move(visit)) {}
  std::string path_of(std::string_view name) const;
  static double radians(double angle_deg) { return radians_from_degrees(angle_deg); }
  static Uncertain radians(const Uncertain& angle_deg) {
    return {radians_from_degrees(angle_deg.mean), radians_from_degrees(angle_deg.std)};
  }
  template <class T>
  static std::optional<T> radians(const std::optional<T>& angle_deg) {
    return radians(*angle_deg);
  }
  template <class T>
  static void get_degrees(const YamlItem& item, T& target_rad, const NumberRule& rule) {
    T value_deg{};
    if (item.get(value_deg, rule)) target_rad = radians(value_deg);
  }

  YamlItem self_;
  std::shared_ptr<yaml_detail::Visit> visit_;
};

/// A strict reader of one YAML file: every problem is collected, with file, line, full key, fault
/// and remedy, and finish() throws them all at once. Not for use from several threads at a time.
class YamlReader {
 public:
  /// Throws ConfigError where the file cannot be read as YAML at all or is not a map.
  explicit YamlReader(const std::filesystem::path& file);
  /// `file` names the text in messages, and its folder is where relative paths start.
  YamlReader(std::string_view text, const std::filesystem::path& file);

  YamlMap root() const;
  /// Problems noted so far; unknown keys are not among them before finish().
  std::size_t problem_count() const;
  /// Reports keys that nobody asked for, with the nearest that were; then throws ConfigError with
  /// all problems in order of line (the first hundred in full) unless there are none.
  void finish() const;

 private:
  YamlReader(std::shared_ptr<const YamlNode> node, const std::filesystem::path& file);
  std::shared_ptr<yaml_detail::State> state_;
  std::optional<YamlMap> root_;
};

}  // namespace vildar
