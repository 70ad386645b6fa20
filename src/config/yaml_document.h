#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace vildar {

struct YamlNode;

/// One `key: value` of a map. Keys may repeat; YamlReader reports it.
struct YamlEntry {
  std::string key;
  int line = 0;  ///< of the key, 1-based
  std::shared_ptr<const YamlNode> value;
};

/// A value of a YAML file as written: no scalar has been turned into a number or a truth value yet.
struct YamlNode {
  enum class Kind { null, scalar, list, map };
  Kind kind = Kind::null;
  int line = 0;  ///< 1-based
  std::string scalar;
  bool quoted = false;  ///< a scalar in quotes is a text, never a number
  std::vector<std::shared_ptr<const YamlNode>> items;
  std::vector<YamlEntry> entries;
  std::size_t expanded_nodes = 1;  ///< this node and all below it, aliases written out
};

inline constexpr std::size_t kLargestYaml_bytes = 1u << 20;
inline constexpr std::size_t kMostYamlNodes = 100'000;  ///< aliases written out

/// The one document of a file. Throws ConfigError where the file is missing, not a plain file,
/// empty, larger than kLargestYaml_bytes, of more than kMostYamlNodes nodes, or not YAML; the line
/// is that of the fault.
std::shared_ptr<const YamlNode> parse_yaml_file(const std::filesystem::path& file);

/// The same of a text; `file` is the name that messages carry.
std::shared_ptr<const YamlNode> parse_yaml_text(std::string_view text, const std::string& file);

}  // namespace vildar
