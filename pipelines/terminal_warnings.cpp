#include "pipelines/terminal_warnings.h"

#include <algorithm>
#include <cctype>
#include <map>

namespace vildar {
namespace {

std::string without_numbers(std::string text) {
  std::erase_if(text, [](unsigned char c) { return std::isdigit(c) || c == '.' || c == '-'; });
  return text;
}

}  // namespace

std::vector<std::string> terminal_warnings(std::span<const std::string> warnings) {
  constexpr std::size_t kShown = 3;
  std::vector<std::vector<std::string>> kinds;
  std::map<std::string, std::size_t> places;
  for (const std::string& warning : warnings) {
    const auto [place, is_new] = places.try_emplace(without_numbers(warning), kinds.size());
    if (is_new) kinds.emplace_back();
    kinds[place->second].push_back(warning);
  }
  std::vector<std::string> told;
  for (const std::vector<std::string>& alike : kinds) {
    const std::size_t shown = alike.size() > kShown + 1 ? kShown : alike.size();
    told.insert(told.end(), alike.begin(), alike.begin() + static_cast<std::ptrdiff_t>(shown));
    if (shown < alike.size())
      told.push_back("and " + std::to_string(alike.size() - shown) +
                     " more like the last one (run.json has them all)");
  }
  return told;
}

}  // namespace vildar
