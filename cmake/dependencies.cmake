# Everything comes from Debian 12's packages except cpp-httplib, which scripts/setup fetches in a newer version.
find_package(Threads REQUIRED)
find_package(TBB REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(FastFloat REQUIRED)
find_package(draco REQUIRED)
find_package(Protobuf CONFIG QUIET)
if(NOT Protobuf_FOUND)
  find_package(Protobuf REQUIRED)
endif()
find_package(gRPC CONFIG REQUIRED)
find_package(absl REQUIRED)
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)
find_package(prometheus-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(SECCOMP REQUIRED IMPORTED_TARGET libseccomp)
find_program(PROTOC protoc REQUIRED)
find_program(GRPC_CPP_PLUGIN grpc_cpp_plugin REQUIRED)

# google/rpc/*.proto, for rich errors; Debian ships them with the gogo googleapis.
find_path(GOOGLE_RPC_PROTO_DIR google/rpc/status.proto
  PATHS /usr/share/gocode/src/github.com/gogo/googleapis REQUIRED)

# 0.11 (Debian 12's own) ignores its payload limit and cannot see a client that left: refuse it here, not in production.
find_path(HTTPLIB_INCLUDE_DIR httplib.h PATHS /usr/local/include REQUIRED)
file(STRINGS "${HTTPLIB_INCLUDE_DIR}/httplib.h" httplib_version_line REGEX "define CPPHTTPLIB_VERSION \"")
string(REGEX MATCH "[0-9]+\\.[0-9]+(\\.[0-9]+)?" HTTPLIB_VERSION "${httplib_version_line}")
if(HTTPLIB_VERSION VERSION_LESS 0.41)
  message(FATAL_ERROR "cpp-httplib ${HTTPLIB_VERSION} in ${HTTPLIB_INCLUDE_DIR} is too old: Burnish needs 0.41 or newer. "
                      "Run scripts/setup, which installs it.")
endif()

# Pictures: only the command line draws them.
if(BURNISH_RENDER)
  find_package(PNG REQUIRED)
  find_package(Freetype REQUIRED)
  find_package(embree 3 REQUIRED NO_MODULE)
  find_file(BURNISH_FONT OpenSans-Regular.ttf PATHS /usr/share/fonts/truetype/open-sans REQUIRED)
endif()
