// Certificates for both transports, read again when their files change.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "core/run/error.h"

struct ssl_ctx_st;

namespace burnish {

struct TlsFiles {
  std::string certificate;  ///< PEM: the server's, then those between it and its authority
  std::string key;          ///< PEM
  std::string client_ca;    ///< PEM: whose certificates callers must show; empty: they need none

  bool given() const { return !certificate.empty() || !key.empty() || !client_ca.empty(); }
};

/// OpenSSL's contexts of these files, one for each of their states. Thread-safe.
class TlsContexts {
 public:
  /// Errors: BadOption when a file is missing, cannot be read, or the key is not the certificate's.
  static Result<std::unique_ptr<TlsContexts>> load(const TlsFiles& files);

  /// Of the files as they were last understood.
  std::shared_ptr<ssl_ctx_st> current() const;

  /// Reads them again when one is another than before. Files that cannot be used are logged, and what was
  /// there stays.
  void reload_if_changed();

  const TlsFiles& files() const { return files_; }

 private:
  struct Stamp {
    std::filesystem::file_time_type times[3] = {};
    friend bool operator==(const Stamp&, const Stamp&) = default;
  };
  explicit TlsContexts(TlsFiles files) : files_(std::move(files)) {}
  Stamp stamp() const;
  Result<> read();

  const TlsFiles files_;
  mutable std::mutex mutex_;  ///< guards what follows
  Stamp stamp_;
  std::shared_ptr<ssl_ctx_st> context_;
};

}  // namespace burnish
