// The report as a header of the answer.
#pragma once

#include <cstddef>
#include <string>

#include "burnish/v1/smoothing.pb.h"

namespace burnish {

/// Proxies and clients cap header lines at 4 KiB and more.
inline constexpr std::size_t kLongestReportHeader = 3072;

/// Compact JSON in ASCII of at most kLongestReportHeader characters: the last warnings are cut first, then
/// the parameters.
std::string report_header(const v1::SmoothReport& report);

}  // namespace burnish
