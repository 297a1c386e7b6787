// What query strings ask for.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "burnish/v1/smoothing.pb.h"
#include "core/run/error.h"

namespace burnish {

using Query = std::multimap<std::string, std::string>;
using Timeout = std::optional<std::chrono::milliseconds>;

inline constexpr std::uint32_t kLongestTimeoutMs = 24 * 60 * 60 * 1000;

/// A number of DracoOptions, under its name in the query.
struct DracoNumber {
  const char* name;
  void (v1::DracoOptions::*set)(std::uint32_t);
  std::uint32_t most;
};
inline constexpr DracoNumber kDracoNumbers[] = {
    {"position_bits", &v1::DracoOptions::set_position_bits, 30},
    {"normal_bits", &v1::DracoOptions::set_normal_bits, 30},
    {"texture_coordinate_bits", &v1::DracoOptions::set_texture_coordinate_bits, 30},
    {"color_bits", &v1::DracoOptions::set_color_bits, 30},
    {"generic_bits", &v1::DracoOptions::set_generic_bits, 30},
    {"speed", &v1::DracoOptions::set_speed, 10},
};

/// timeout_ms, whatever else the query holds. Errors: BadOption.
Result<Timeout> parse_timeout(const Query& query);

/// That there is nothing but timeout_ms. Errors: `cause`, whose sentence ends in `why`.
Result<> check_only_timeout(const Query& query, Cause cause, const std::string& why);

/// method, output=obj|drc|ply|stl|off|glb, draco_method=sequential|edgebreaker, the Draco numbers,
/// pinned_vertices=0,1,2, pinned_group=NAME, pinned_attribute=NAME; every other name but timeout_ms is a
/// parameter of the method. Errors: UnknownMethod, UnknownOption, BadOption (a name given twice, a bad
/// value), each naming the parameter.
Result<v1::SmoothOptions> parse_query_options(const Query& query);

}  // namespace burnish
