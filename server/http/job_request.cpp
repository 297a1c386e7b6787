#include "server/http/job_request.h"

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <string>

#include "server/http/body_reader.h"
#include "server/http/media_type.h"
#include "server/http/options_json.h"
#include "server/http/smooth_answer.h"

namespace burnish {
namespace {

constexpr std::uint64_t kFormFraming = 64 << 10;  // boundaries and part headers
constexpr std::size_t kLongestText = 1000;        // of a part that is a word
constexpr std::string_view kMeshSha256 = "mesh_sha256", kReferenceSha256 = "reference_sha256",
                           kPriority = "priority";

/// The parts of a form by their names.
class Form {
 public:
  /// Errors: UnknownOption for another name than `names`, BadOption for one given twice.
  static Result<Form> read(const std::vector<FormPart>& parts,
                           std::initializer_list<std::string_view> names) {
    Form form;
    for (const FormPart& part : parts) {
      if (std::ranges::find(names, part.name) == names.end()) {
        return Error{Cause::UnknownOption, "there is no part '" + part.name + "'", part.name};
      }
      if (!form.parts_.emplace(part.name, &part).second) {
        return Error{Cause::BadOption, "part '" + part.name + "' is given more than once", part.name};
      }
    }
    return form;
  }

  /// A part of text; empty when it is missing.
  std::string text(std::string_view name) const {
    const FormPart* const part = find(name);
    return part ? std::string(part->content.bytes.substr(0, kLongestText)) : "";
  }

  const FormPart* find(std::string_view name) const {
    const auto found = parts_.find(name);
    return found == parts_.end() ? nullptr : found->second;
  }

  /// Fills the bytes and the format of a mesh. Errors: BadOption, EmptyMesh, UnsupportedFormat.
  Result<> read_mesh(const std::string& name, std::string_view& bytes, std::optional<Format>& format) const {
    const FormPart* const part = find(name);
    if (!part) return Error{Cause::BadOption, "part '" + name + "' is missing", name};
    if (part->content.bytes.empty()) {
      return Error{Cause::EmptyMesh, "part '" + name + "' has no bytes", name};
    }
    const auto told = mesh_format(part->content_type);
    if (!told) return Error{told.error().cause, "part '" + name + "': " + told.error().message, name};
    bytes = part->content.bytes;
    format = *told;
    return {};
  }

 private:
  std::map<std::string_view, const FormPart*> parts_;
};

/// From the part of a form, or from the query when there is none.
Result<v1::SmoothOptions> read_options(const HttpRequest& request, const FormPart* part,
                                       const SmoothService& service) {
  if (!part) return parse_query_options(request.query);
  const auto alone =
      check_only_timeout(request.query, Cause::BadOption, "belongs into the part 'options' of this request");
  if (!alone) return alone.error();
  return parse_options_json(part->content.bytes, service);
}

Result<JobRequest<SmoothJob>> read_smooth_form(const HttpRequest& request, const SmoothService& service) {
  const auto form = Form::read(request.parts, {"mesh", "reference", "options"});
  if (!form) return form.error();
  JobRequest<SmoothJob> read;
  SmoothJob& job = read.job;
  if (auto mesh = form->read_mesh("mesh", job.mesh, job.format); !mesh) return mesh.error();
  if (form->find("reference")) {
    const auto reference = form->read_mesh("reference", job.reference, job.reference_format);
    if (!reference) return reference.error();
  }
  auto options = read_options(request, form->find("options"), service);
  if (!options) return options.error();
  job.options = *std::move(options);
  return read;
}

Result<JobRequest<SmoothJob>> read_smooth_body(const HttpRequest& request) {
  const auto format = mesh_format(request.header("Content-Type"));
  if (!format) return format.error();
  auto options = parse_query_options(request.query);
  if (!options) return options.error();
  JobRequest<SmoothJob> read;
  read.job.mesh = request.body.bytes;
  read.job.format = *format;
  read.job.options = *std::move(options);
  return read;
}

/// How a form's bytes are shared out is not known yet: as the mesh first, the rest as the reference. Errors:
/// TooLarge.
Result<ExpectedJob> expect_bytes(const HttpRequest& head, const RequestLimits& limits) {
  ExpectedJob expected;
  const std::string_view digits = head.header("Content-Length");
  std::from_chars(digits.data(), digits.data() + digits.size(), expected.mesh_bytes);
  if (!is_form(head.header("Content-Type"))) return expected;
  const std::uint64_t length = expected.mesh_bytes, one = limits.mesh.max_bytes;
  const std::uint64_t most = 2 * one + limits.max_option_bytes + kFormFraming;
  if (length > most) {
    return Error{Cause::TooLarge, "the form has " + std::to_string(length) +
                                      " bytes; two meshes at their limit (max-bytes) have " +
                                      std::to_string(most)};
  }
  expected.mesh_bytes = std::min(length, one);
  expected.reference_bytes = std::min(length - expected.mesh_bytes, one);
  return expected;
}

Result<ExpectedJob> expect(const HttpRequest& head, const RequestLimits& limits) {
  const auto decoder = BodyDecoder::for_encoding(head.header("Content-Encoding"));
  if (!decoder) return decoder.error();
  const auto timeout = parse_timeout(head.query);
  if (!timeout) return timeout.error();
  auto expected = expect_bytes(head, limits);
  if (expected) expected->timeout = *timeout;
  return expected;
}

Result<> check_compare_head(const HttpRequest& head) {
  if (!is_form(head.header("Content-Type"))) {
    return Error{Cause::UnsupportedFormat,
                 "to compare takes multipart/form-data with the parts 'reference' and 'mesh'"};
  }
  return check_only_timeout(head.query, Cause::UnknownOption, "does not exist here; there is timeout_ms");
}

}  // namespace

Result<JobRequest<SmoothJob>> read_smooth(const HttpRequest& request, const SmoothService& service) {
  const bool form = is_form(request.header("Content-Type"));
  auto read = form ? read_smooth_form(request, service) : read_smooth_body(request);
  const auto timeout = parse_timeout(request.query);
  if (!timeout) return timeout.error();
  if (read) read->timeout = *timeout;
  return read;
}

namespace {

/// The words of a submission that are no options.
struct SubmissionWords {
  std::string mesh_sha256, reference_sha256, priority;
};

/// Takes them out of the query.
SubmissionWords take_words(Query& query) {
  SubmissionWords words;
  const auto take = [&query](std::string_view name, std::string& into) {
    const auto found = query.find(std::string(name));
    if (found == query.end()) return;
    into = found->second;
    query.erase(found);  // a second one stays, and is refused as what it then is: unknown
  };
  take(kMeshSha256, words.mesh_sha256);
  take(kReferenceSha256, words.reference_sha256);
  take(kPriority, words.priority);
  return words;
}

Result<v1::JobPriority> priority_of(const std::string& text) {
  if (text.empty() || text == "normal") return v1::JOB_PRIORITY_NORMAL;
  if (text == "low") return v1::JOB_PRIORITY_LOW;
  return Error{Cause::BadOption, "priority is '" + text + "', expected normal or low",
               std::string(kPriority)};
}

/// A mesh that comes as a part of its own, or is named by one.
Result<SubmittedMesh> read_submitted(const Form& form, const std::string& name, std::string sha256) {
  SubmittedMesh mesh{.sha256 = std::move(sha256)};
  if (mesh.sha256.empty()) mesh.sha256 = form.text(name + "_sha256");
  if (!form.find(name)) return mesh;
  if (!mesh.sha256.empty()) {
    return Error{Cause::BadOption, "part '" + name + "' comes with bytes and by its SHA-256", name};
  }
  if (auto read = form.read_mesh(name, mesh.bytes, mesh.format); !read) return std::move(read).error();
  return mesh;
}

}  // namespace

Result<Submission> read_submission(const HttpRequest& request, const SmoothService& service) {
  HttpRequest rest{.method = request.method, .path = request.path, .query = request.query};
  SubmissionWords words = take_words(rest.query);
  Submission submission;
  submission.idempotency_key = request.header("Idempotency-Key");
  const bool is_form_body = is_form(request.header("Content-Type"));
  std::optional<Form> form;
  if (is_form_body) {
    auto read =
        Form::read(request.parts, {"mesh", "reference", "options", kMeshSha256, kReferenceSha256, kPriority});
    if (!read) return std::move(read).error();
    form = std::move(read).value();
    if (words.priority.empty()) words.priority = form->text(kPriority);
    auto mesh = read_submitted(*form, "mesh", words.mesh_sha256);
    if (!mesh) return std::move(mesh).error();
    auto reference = read_submitted(*form, "reference", words.reference_sha256);
    if (!reference) return std::move(reference).error();
    submission.mesh = std::move(mesh).value();
    submission.reference = std::move(reference).value();
  } else {
    submission.reference.sha256 = words.reference_sha256;
    submission.mesh.sha256 = words.mesh_sha256;
    submission.mesh.bytes = request.body.bytes;
    if (!submission.mesh.bytes.empty()) {
      if (!submission.mesh.sha256.empty())
        return Error{Cause::BadOption, "the mesh comes as the body and by its SHA-256",
                     std::string(kMeshSha256)};
      const auto format = mesh_format(request.header("Content-Type"));
      if (!format) return format.error();
      submission.mesh.format = *format;
    }
  }
  const auto timeout = parse_timeout(rest.query);
  if (!timeout) return timeout.error();
  submission.timeout = *timeout;
  const auto priority = priority_of(words.priority);
  if (!priority) return priority.error();
  submission.priority = *priority;
  auto options = read_options(rest, form ? form->find("options") : nullptr, service);
  if (!options) return std::move(options).error();
  submission.options = std::move(options).value();
  return submission;
}

Result<> expect_submission(const HttpRequest& head, const SmoothService& service) {
  const auto decoder = BodyDecoder::for_encoding(head.header("Content-Encoding"));
  if (!decoder) return decoder.error();
  const auto bytes = expect_bytes(head, service.limits());
  if (!bytes) return bytes.error();
  if (auto fits = service.check_size(bytes->mesh_bytes, "the mesh"); !fits) return fits;
  if (is_form(head.header("Content-Type"))) return {};  // its options are in its body
  Query query = head.query;
  if (auto fine = priority_of(take_words(query).priority); !fine) return fine.error();
  const auto options = parse_query_options(query);
  if (!options) return options.error();
  return service.check(*options);
}

Result<ExpectedJob> expect_smooth(const HttpRequest& head, const SmoothService& service) {
  if (auto type = choose_smooth_answer(head.header("Accept"), {}); !type) return type.error();
  if (!is_form(head.header("Content-Type"))) {  // a form's options are in its body
    const auto read = read_smooth_body(head);
    if (!read) return read.error();
    if (auto fine = service.check(read->job.options); !fine) return fine.error();
  }
  return expect(head, service.limits());
}

Result<JobRequest<CompareJob>> read_compare(const HttpRequest& request) {
  if (auto fine = check_compare_head(request); !fine) return fine.error();
  const auto form = Form::read(request.parts, {"reference", "mesh"});
  if (!form) return form.error();
  JobRequest<CompareJob> read;
  CompareJob& job = read.job;
  const auto reference = form->read_mesh("reference", job.reference, job.reference_format);
  if (!reference) return reference.error();
  if (auto mesh = form->read_mesh("mesh", job.mesh, job.format); !mesh) return mesh.error();
  const auto timeout = parse_timeout(request.query);
  if (!timeout) return timeout.error();
  read.timeout = *timeout;
  return read;
}

Result<ExpectedJob> expect_compare(const HttpRequest& head, const RequestLimits& limits) {
  if (auto fine = check_compare_head(head); !fine) return fine.error();
  return expect(head, limits);
}

}  // namespace burnish
