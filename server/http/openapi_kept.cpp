#include "server/http/openapi_kept.h"

#include <utility>
#include <vector>

#include "server/http/media_type.h"
#include "server/http/openapi_components.h"
#include "server/http/openapi_schemas.h"

namespace burnish {
namespace {

using Json = nlohmann::ordered_json;

struct Operation {
  Endpoint endpoint;
  const char *verb, *summary, *description;
  int status;
  const char* type;                       ///< of the answer; null: it has no body
  const char* schema;                     ///< of the components; null: bytes
  std::vector<const char*> headers = {};  ///< of the answer
  std::vector<const char*> parameters = {};
};

const std::vector<Operation>& operations() {
  using enum Endpoint;
  static const std::vector<Operation> kOperations = {
      {Jobs,
       "post",
       "Hand over a job",
       "As POST /v1/smooth, but the answer comes when the job is safe on disk: it ends exactly once, "
       "whatever "
       "happens to the connection or to the server. Instead of bytes mesh_sha256 and reference_sha256 may "
       "name "
       "meshes that were uploaded or used before.",
       202,
       "application/json",
       "Job",
       {"Location", "Retry-After"},
       {"mesh_sha256", "reference_sha256", "priority", "IdempotencyKey"}},
      {Jobs,
       "get",
       "The caller's jobs, newest first",
       "Without their reports.",
       200,
       "application/json",
       "ListJobsResponse",
       {},
       {"page_size", "page_token"}},
      {Job,
       "get",
       "A job as it is",
       "With Prefer: wait=N the answer waits until the job has ended, for N seconds. A caller who accepts "
       "meshes "
       "and no JSON is sent to the result with 303 once it is there.",
       200,
       "application/json",
       "Job",
       {"Retry-After", "Preference-Applied"},
       {"Prefer"}},
      {Job, "delete", "Cancel or remove a job",
       "A job that has not ended is cancelled: 202. One that has ended is removed with its result: 204.", 204,
       nullptr, nullptr},
      {JobEvents, "get", "A job whenever it changes",
       "Server-sent events named job, each with the Job as JSON; the last one has ended.", 200,
       "text/event-stream", nullptr},
      {JobMesh,
       "get",
       "The smoothed mesh",
       "Range, If-Range and If-None-Match are understood.",
       200,
       "application/octet-stream",
       nullptr,
       {"ETag", "Accept-Ranges", "Burnish-Report"},
       {"Range"}},
      {JobReport, "get", "The report of a job that succeeded", "As in the job.", 200, "application/json",
       "SmoothReport"},
      {Uploads,
       "post",
       "Begin an upload",
       "With the first bytes, all or none. Repr-Digest: sha-256=:BASE64: announces the SHA-256; an upload of "
       "a mesh "
       "that the caller has sent before is complete at once.",
       201,
       "application/json",
       "Upload",
       {"Location", "Upload-Offset", "Upload-Complete", "Upload-Length"},
       {"UploadLength", "UploadComplete", "ReprDigest"}},
      {Upload,
       "get",
       "How much of an upload there is",
       "Also in the headers.",
       200,
       "application/json",
       "Upload",
       {"Upload-Offset", "Upload-Complete", "Upload-Length"}},
      {Upload,
       "patch",
       "Append to an upload",
       "What came before a connection broke is kept: ask for Upload-Offset and go on from there. Another "
       "offset is "
       "409, which tells the right one.",
       200,
       "application/json",
       "Upload",
       {"Upload-Offset", "Upload-Complete", "Upload-Length"},
       {"UploadOffset", "UploadComplete"}},
      {Upload, "delete", "Forget an upload", "A complete one's mesh stays for the jobs that use it.", 204,
       nullptr, nullptr},
  };
  return kOperations;
}

const Operation& operation_of(Endpoint endpoint, const std::string& verb) {
  for (const Operation& each : operations()) {
    if (each.endpoint == endpoint && each.verb == verb) return each;
  }
  return operations().front();
}

Json content(const Operation& operation) {
  if (operation.schema) return openapi_content(operation.type, schema_reference(operation.schema));
  if (std::string_view(operation.type) == kAnyBytesType) {
    return openapi_mesh_content();
  }
  return openapi_content(operation.type, {{"type", "string"}});
}

Json responses(const Operation& operation, const std::string& verb) {
  Json success = {{"description", operation.summary}, {"headers", openapi_answer_headers()}};
  for (const char* name : operation.headers) success["headers"][name] = openapi_reference("headers", name);
  if (operation.type && verb != "head") success["content"] = content(operation);
  Json all = {{std::to_string(operation.status), success}};
  if (operation.endpoint == Endpoint::JobMesh) {
    success["description"] = "The range that was asked for";
    success["headers"]["Content-Range"] = openapi_reference("headers", "Content-Range");
    all["206"] = std::move(success);
    all["304"] = {{"description", "The caller has it already"}, {"headers", openapi_answer_headers()}};
  }
  if (operation.endpoint == Endpoint::Job && verb == "delete") {
    all["202"] = {{"description", "The job was cancelled"},
                  {"headers", openapi_answer_headers()},
                  {"content", openapi_content(kJsonType, schema_reference("Job"))}};
  }
  if (operation.endpoint == Endpoint::Job && verb == "get") {
    all["303"] = {{"description", "The result is there"},
                  {"headers", {{"Location", openapi_reference("headers", "Location")}}},
                  {"content", openapi_content(kJsonType, schema_reference("Job"))}};
  }
  for (const int status : problem_statuses_of_work()) all[std::to_string(status)] = problem_reference(status);
  all["4XX"] = other_problem_reference();
  return all;
}

}  // namespace

std::string kept_name(Endpoint endpoint) {
  switch (endpoint) {
    case Endpoint::Jobs:
      return "Jobs";
    case Endpoint::JobEvents:
      return "JobEvents";
    case Endpoint::JobMesh:
      return "JobMesh";
    case Endpoint::JobReport:
      return "JobReport";
    case Endpoint::Uploads:
      return "Uploads";
    case Endpoint::Upload:
      return "Upload";
    default:
      return "Job";
  }
}

Json kept_operation(const Route& route, const std::string& verb, Json submission) {
  const Operation& operation = operation_of(route.endpoint, verb == "head" ? "get" : verb);
  const bool submits = route.endpoint == Endpoint::Jobs && verb == "post";
  Json result = {
      {"operationId", verb + kept_name(route.endpoint)},
      {"summary", verb == "head" ? std::string(operation.summary) + ": the head alone" : operation.summary},
      {"description", operation.description}};
  Json parameters = submits ? std::move(submission["parameters"])
                            : Json{openapi_reference("parameters", "RequestId"),
                                   openapi_reference("parameters", "traceparent")};
  if (route.path.find("{id}") != std::string_view::npos)
    parameters.push_back(openapi_reference("parameters", "id"));
  for (const char* name : operation.parameters) parameters.push_back(openapi_reference("parameters", name));
  result["parameters"] = std::move(parameters);
  if (submits) result["requestBody"] = std::move(submission["requestBody"]);
  if (route.takes_uploads() && (verb == "post" || verb == "patch")) {
    const char* const type = verb == "post" ? "application/octet-stream" : "application/partial-upload";
    result["requestBody"] = {{"required", verb == "patch"},
                             {"content", {{type, {{"schema", Json::object()}}}}}};
  }
  result["responses"] = responses(operation, verb);
  return result;
}

}  // namespace burnish
