// Who may call, and how much: bearer tokens from a file that holds their SHA-256 alone.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/run/error.h"

namespace burnish {

/// What a token's holder may have; 0: any.
struct Quota {
  double requests_per_second = 0;  ///< as many at once as in a second, 1 at least
  double bytes_per_second = 0;     ///< of meshes; a minute's worth at once
  std::uint64_t max_bytes = 0;     ///< of a mesh
  std::uint32_t jobs = 0;          ///< kept jobs that have not ended
};

struct TokenHolder {
  std::string name;    ///< the owner of jobs and uploads
  std::string sha256;  ///< of the token, in lower case
  Quota quota = {};
};

/// {"tokens": [{"name": "scanner-1", "sha256": "...", "requestsPerSecond": 10, "bytesPerSecond": 1000000,
/// "maxBytes": 100000000, "jobs": 50}, ...]}; all but name and sha256 may be left out. Errors: BadOption,
/// naming the place.
Result<std::vector<TokenHolder>> parse_tokens(std::string_view json);

/// Thread-safe.
class Tokens {
 public:
  using Clock = std::chrono::steady_clock;

  /// Errors: BadOption when the file cannot be read or understood.
  static Result<std::unique_ptr<Tokens>> load(const std::string& path);

  struct Identity {
    std::string owner;
    Quota quota;
  };
  /// "Bearer TOKEN" of a header or of metadata; `counts` as a request. Errors: Unauthenticated, QuotaExceeded
  /// with a time. Takes the same time whichever token it is.
  Result<Identity> identify(std::string_view authorization, bool counts,
                            Clock::time_point now = Clock::now());

  /// Counts bytes of a mesh. Errors: QuotaExceeded with a time.
  Result<> charge(const std::string& owner, std::uint64_t bytes, Clock::time_point now = Clock::now());

  /// Reads the file again when it is another one than before. A file that cannot be understood is logged, and
  /// what was known stays.
  void reload_if_changed();

 private:
  /// What is left of a rate.
  struct Bucket {
    double left = 0;
    Clock::time_point at = {};
  };
  struct Stamp {
    std::filesystem::file_time_type time = {};
    std::uintmax_t size = 0;
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };

  explicit Tokens(std::string path) : path_(std::move(path)) {}
  Result<> read();
  static Stamp stamp_of(const std::string& path);
  static Result<> take(std::map<std::string, Bucket>& buckets, const std::string& owner, double amount,
                       double rate, double most, Clock::time_point now, const std::string& what);

  const std::string path_;
  std::mutex mutex_;  ///< guards what follows
  Stamp stamp_;
  std::vector<TokenHolder> holders_;
  std::map<std::string, Bucket> requests_, bytes_;  ///< by owner
};

}  // namespace burnish
