#include "server/security/tokens.h"

#include <openssl/crypto.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "server/http/strict_json.h"
#include "server/store/file_store.h"

namespace burnish {
namespace {

using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr std::string_view kScheme = "Bearer ";
constexpr std::size_t kLongestName = 64;
constexpr double kMinute = 60;

Error wrong(const std::string& place, const std::string& what) {
  return {Cause::BadOption, place + " " + what, place};
}

Result<double> number_of(const Json& value, const std::string& place) {
  if (!value.is_number() || value.get<double>() < 0) return wrong(place, "is not a number from 0");
  return value.get<double>();
}

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName && std::ranges::all_of(name, [](unsigned char c) {
    return (c < 128 && std::isalnum(c)) || c == '.' || c == '_' || c == '-';
  });
}

Result<TokenHolder> holder_of(const Json& entry, const std::string& place) {
  if (!entry.is_object()) return wrong(place, "is not an object");
  TokenHolder holder;
  for (const auto& [key, value] : entry.items()) {
    std::string at = place;
    at.append(".").append(key);
    if (key == "name" || key == "sha256") {
      if (!value.is_string()) return wrong(at, "is not a string");
      (key == "name" ? holder.name : holder.sha256) = value.get<std::string>();
      continue;
    }
    const auto number = number_of(value, at);
    if (!number) return number.error();
    if (key == "requestsPerSecond") {
      holder.quota.requests_per_second = *number;
    } else if (key == "bytesPerSecond") {
      holder.quota.bytes_per_second = *number;
    } else if (key == "maxBytes" && *number < 1e15) {
      holder.quota.max_bytes = static_cast<std::uint64_t>(*number);
    } else if (key == "jobs" && *number < 1e9) {
      holder.quota.jobs = static_cast<std::uint32_t>(*number);
    } else {
      return wrong(at, key == "jobs" || key == "maxBytes" ? "is too large" : "does not exist");
    }
  }
  if (!is_name(holder.name)) return wrong(place + ".name", "is not 1 to 64 letters, digits, dots, dashes");
  auto sha256 = parse_sha256(holder.sha256, place + ".sha256");
  if (!sha256) return std::move(sha256).error();
  holder.sha256 = std::move(sha256).value();
  return holder;
}

}  // namespace

Result<std::vector<TokenHolder>> parse_tokens(std::string_view text) {
  const auto json = parse_strict_json(text, "file");
  if (!json) return json.error();
  if (!json->is_object() || json->size() != 1 || !json->contains("tokens") || !(*json)["tokens"].is_array())
    return wrong("file", "is not an object with the array \"tokens\" alone");
  std::vector<TokenHolder> holders;
  std::set<std::string> hashes;
  for (const Json& entry : (*json)["tokens"]) {
    const std::string place = "tokens[" + std::to_string(holders.size()) + "]";
    auto holder = holder_of(entry, place);
    if (!holder) return std::move(holder).error();
    if (!hashes.insert(holder->sha256).second) return wrong(place + ".sha256", "is given twice");
    holders.push_back(std::move(holder).value());
  }
  return holders;
}

Result<std::unique_ptr<Tokens>> Tokens::load(const std::string& path) {
  auto tokens = std::unique_ptr<Tokens>(new Tokens(path));
  if (auto read = tokens->read(); !read) return std::move(read).error();
  return tokens;
}

Tokens::Stamp Tokens::stamp_of(const std::string& path) {
  std::error_code failure;
  return {std::filesystem::last_write_time(path, failure), std::filesystem::file_size(path, failure)};
}

Result<> Tokens::read() {
  const Stamp stamp = stamp_of(path_);
  std::ifstream file(path_, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  const std::string where = "the tokens file '" + path_ + "' (tokens) ";
  if (!file.is_open() || file.bad()) return Error{Cause::BadOption, where + "cannot be read"};
  auto holders = parse_tokens(text.str());
  const std::lock_guard lock(mutex_);
  stamp_ = stamp;
  if (!holders) return Error{Cause::BadOption, where + "is wrong: " + holders.error().message};
  holders_ = std::move(holders).value();
  return {};
}

void Tokens::reload_if_changed() {
  {
    const std::lock_guard lock(mutex_);
    if (stamp_of(path_) == stamp_) return;
  }
  if (auto again = read(); !again) {
    spdlog::error("tokens: {}; the former ones stay", again.error().message);
  } else {
    spdlog::info("tokens: read again");
  }
}

Result<Tokens::Identity> Tokens::identify(std::string_view authorization, bool counts,
                                          Clock::time_point now) {
  if (!authorization.starts_with(kScheme))
    return Error{Cause::Unauthenticated, "the server asks for a token: Authorization: Bearer TOKEN"};
  const std::string sha256 = sha256_of(authorization.substr(kScheme.size()));
  const std::lock_guard lock(mutex_);
  const TokenHolder* found = nullptr;
  for (const TokenHolder& holder : holders_) {  // all of them, so that time tells nothing
    if (CRYPTO_memcmp(holder.sha256.data(), sha256.data(), sha256.size()) == 0) found = &holder;
  }
  if (!found) return Error{Cause::Unauthenticated, "the token is not known"};
  const double rate = counts ? found->quota.requests_per_second : 0;
  if (auto taken = take(requests_, found->name, 1, rate, std::max(1.0, rate), now, "requests"); !taken)
    return std::move(taken).error();
  return Identity{found->name, found->quota};
}

Result<> Tokens::charge(const std::string& owner, std::uint64_t bytes, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const auto holder = std::ranges::find(holders_, owner, &TokenHolder::name);
  if (holder == holders_.end()) return {};
  const double rate = holder->quota.bytes_per_second;
  // A mesh larger than a minute's worth must not be impossible: it only empties the bucket.
  const double amount = std::min(static_cast<double>(bytes), rate * kMinute);
  return take(bytes_, owner, amount, rate, rate * kMinute, now, "bytes");
}

Result<> Tokens::take(std::map<std::string, Bucket>& buckets, const std::string& owner, double amount,
                      double rate, double most, Clock::time_point now, const std::string& what) {
  if (rate <= 0) return {};
  const auto [found, is_new] = buckets.try_emplace(owner, Bucket{most, now});
  Bucket& bucket = found->second;
  bucket.left = std::min(most, bucket.left + rate * std::chrono::duration<double>(now - bucket.at).count());
  bucket.at = now;
  if (bucket.left >= amount) {
    bucket.left -= amount;
    return {};
  }
  return Error{.cause = Cause::QuotaExceeded,
               .message = "the token may have " + std::to_string(static_cast<std::uint64_t>(rate)) + " " +
                          what + " a second",
               .retry_after =
                   milliseconds(static_cast<std::int64_t>(std::ceil(1000 * (amount - bucket.left) / rate)))};
}

}  // namespace burnish
