#include "sink/html.h"

#include "core/quantity.h"
#include "core/text.h"

namespace vildar {
namespace {

/// Digits after the point that show the uncertainty with one or two significant ones.
int digits_for(const SpeedEstimate& speed) { return kmh_from_mps(speed.std_mps) < 0.095 ? 2 : 1; }

}  // namespace

std::string escaped(std::string_view text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char letter : text) {
    switch (letter) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default: safe += letter;
    }
  }
  return safe;
}

std::string table_cell(std::string_view label, std::string_view css_class,
                       const std::string& html) {
  return "<td class=\"" + std::string(css_class) + "\" data-label=\"" + std::string(label) + "\">" +
         html + "</td>";
}

std::string direction_words(Direction direction) {
  const std::string name(name_of(direction));
  return "<span><span class=\"dot " + name + "\"></span>" + name + "</span>";
}

std::string speed_words_kmh(const SpeedEstimate& speed) {
  const int digits = digits_for(speed);
  return fixed_text(kmh_from_mps(speed.speed_mps), digits) + " ± " +
         fixed_text(kmh_from_mps(speed.std_mps), digits);
}

std::string interval_words_kmh(const SpeedEstimate& speed) {
  const int digits = digits_for(speed);
  return fixed_text(kmh_from_mps(speed.lo95_mps), digits) + " to " +
         fixed_text(kmh_from_mps(speed.hi95_mps), digits);
}

}  // namespace vildar
