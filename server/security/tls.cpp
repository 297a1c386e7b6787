#include "server/security/tls.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <spdlog/spdlog.h>

#include <utility>

namespace burnish {
namespace {

constexpr unsigned char kHttp11[] = "\x08http/1.1";

Error unusable(const std::string& what, const std::string& file, const char* setting) {
  const unsigned long code = ERR_get_error();
  const char* const why = code ? ERR_reason_error_string(code) : nullptr;
  ERR_clear_error();
  return {Cause::BadOption, what + " '" + file + "' (" + setting + ") cannot be used" +
                                (why ? std::string(": ") + why : std::string())};
}

/// ALPN: HTTP/1.1 for who offers it; who offers only others goes on without.
int choose_protocol(SSL*, const unsigned char** chosen, unsigned char* size, const unsigned char* offered,
                    unsigned offered_size, void*) {
  unsigned char* found = nullptr;
  if (SSL_select_next_proto(&found, size, kHttp11, sizeof kHttp11 - 1, offered, offered_size) !=
      OPENSSL_NPN_NEGOTIATED) {
    return SSL_TLSEXT_ERR_NOACK;
  }
  *chosen = found;
  return SSL_TLSEXT_ERR_OK;
}

Result<std::shared_ptr<SSL_CTX>> context_of(const TlsFiles& files) {
  const std::shared_ptr<SSL_CTX> context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (!context) return Error{Cause::OutOfMemory, "no memory for TLS"};
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_alpn_select_cb(context.get(), choose_protocol, nullptr);
  ERR_clear_error();
  if (SSL_CTX_use_certificate_chain_file(context.get(), files.certificate.c_str()) != 1)
    return unusable("the certificate", files.certificate, "tls-certificate");
  if (SSL_CTX_use_PrivateKey_file(context.get(), files.key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      SSL_CTX_check_private_key(context.get()) != 1) {
    return unusable("the key", files.key, "tls-key");
  }
  if (files.client_ca.empty()) return context;
  if (SSL_CTX_load_verify_locations(context.get(), files.client_ca.c_str(), nullptr) != 1)
    return unusable("the callers' authority", files.client_ca, "tls-client-ca");
  SSL_CTX_set_client_CA_list(context.get(), SSL_load_client_CA_file(files.client_ca.c_str()));
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT, nullptr);
  return context;
}

}  // namespace

Result<std::unique_ptr<TlsContexts>> TlsContexts::load(const TlsFiles& files) {
  if (files.certificate.empty() || files.key.empty())
    return Error{Cause::BadOption, "TLS needs both tls-certificate and tls-key"};
  auto contexts = std::unique_ptr<TlsContexts>(new TlsContexts(files));
  if (auto read = contexts->read(); !read) return std::move(read).error();
  return contexts;
}

TlsContexts::Stamp TlsContexts::stamp() const {
  Stamp result;
  std::error_code failure;
  std::size_t at = 0;
  for (const std::string* const file : {&files_.certificate, &files_.key, &files_.client_ca})
    result.times[at++] = std::filesystem::last_write_time(*file, failure);
  return result;
}

Result<> TlsContexts::read() {
  const Stamp now = stamp();
  auto context = context_of(files_);
  const std::lock_guard lock(mutex_);
  stamp_ = now;
  if (!context) return std::move(context).error();
  context_ = std::move(context).value();
  return {};
}

void TlsContexts::reload_if_changed() {
  {
    const std::lock_guard lock(mutex_);
    if (stamp() == stamp_) return;
  }
  if (auto again = read(); !again) {
    spdlog::error("tls: {}; the former certificate stays", again.error().message);
  } else {
    spdlog::info("tls: certificates read again");
  }
}

std::shared_ptr<SSL_CTX> TlsContexts::current() const {
  const std::lock_guard lock(mutex_);
  return context_;
}

}  // namespace burnish
