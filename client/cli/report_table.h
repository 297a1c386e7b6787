// Reports as a person reads them.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>

#include "burnish/v1/smoothing.pb.h"

namespace burnish::cli {

void print_report(std::ostream& out, const v1::SmoothReport& report);
void print_comparison(std::ostream& out, const v1::CompareResponse& comparison);

/// What `smooth --dry-run` knows: the parts of a report that smoothing does not fill, about how long
/// smoothing would take on one core, and about how much memory all would.
void print_forecast(std::ostream& out, const std::string& file, const v1::SmoothReport& report,
                    double seconds, std::uint64_t memory_bytes);

/// Where a heat map was written, and what its colours stand for.
void print_heatmap(std::ostream& out, const std::string& file, double most, double largest);

}  // namespace burnish::cli
