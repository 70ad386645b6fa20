#pragma once

#include <string_view>

namespace vildar {

/// The style sheet of the report: screen in light and dark, narrow windows, print.
extern const std::string_view kReportStyle;

}  // namespace vildar
