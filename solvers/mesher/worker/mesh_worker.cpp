// carillon-mesh REQUEST REPLY: the mesher's own process. It reads a request (CBOR), limits itself,
// works, and writes a reply (CBOR): {"result": ...} or {"error": {kind, message, hint}}. No MPI and
// no PETSc here; solvers/mesher/mesh_child.hpp is its caller's side.
#include <fmt/core.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/sanitizers.hpp"
#include "solvers/mesh/shape_source.hpp"
#include "solvers/mesher/mesh_child.hpp"
#include "solvers/mesher/worker/make_tet_mesh.hpp"
#include "solvers/mesher/worker/read_file.hpp"

namespace {

using nlohmann::json;
namespace core = carillon::core;
namespace solvers = carillon::solvers;

void limit_myself(const json& request) {
  // The parent's death must not leave a mesher behind; if it has died already, so do we.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != request.at("parent").get<pid_t>()) _exit(1);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const auto bytes = request.at("memory").get<rlim_t>();
  if (!core::address_sanitizer && bytes > 0) {
    const rlimit memory{bytes, bytes};
    setrlimit(RLIMIT_AS, &memory);
  }
}

json colours(const solvers::mesh::MeshFile& file, const std::vector<double>& coordinates) {
  std::vector<carillon::Vec3> points;
  for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3)
    points.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  json flat = json::array();
  for (const carillon::Vec3& colour : solvers::mesher::colours_of(file, points))
    for (const double value : colour) flat.push_back(value);
  return flat;
}

json work(const json& request) {
  const std::string task = request.at("task");
  if (task == "contents")
    return solvers::mesher::describe_files(request.at("paths").get<std::vector<std::string>>());
  const auto mesh_request = solvers::mesh::mesh_request_from_json(request.at("request"));
  if (task == "diagnose")
    return solvers::mesh::to_json(solvers::mesher::diagnose_file(mesh_request.file));
  if (task == "colours")
    return colours(mesh_request.file, request.at("points").get<std::vector<double>>());
  return solvers::mesh::to_json(
      solvers::mesher::make_tet_mesh(mesh_request, request.at("cache").get<std::string>()));
}

json error(const char* kind, const core::Error& e) {
  return {{"error", {{"kind", kind}, {"message", e.message()}, {"hint", e.hint()}}}};
}

json answer(const json& request) {
  try {
    return {{"result", work(request)}};
  } catch (const core::InputError& e) {
    return error("input", e);
  } catch (const core::FileError& e) {
    return error("file", e);
  } catch (const core::LimitError& e) {
    return error("limit", e);
  } catch (const core::Error& e) {
    return error("solver", e);
  } catch (const std::bad_alloc&) {
    return error("memory", core::SolverError(""));
  } catch (const std::exception& e) {
    return error("solver", core::SolverError(fmt::format("the mesher failed: {}", e.what())));
  }
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::fputs("carillon-mesh is started by carillon; it is of no use alone\n", stderr);
    return 2;
  }
  try {
    const json request = json::from_cbor(core::read_file(arguments[1]));
    limit_myself(request);
    const auto bytes = json::to_cbor(answer(request));
    std::ofstream reply(arguments[2], std::ios::binary);
    reply.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
    reply.close();
    if (!reply) throw core::FileError(fmt::format("{}: cannot be written", arguments[2]));
  } catch (const core::FileError& e) {  // one that is no part of the request
    fmt::print(stderr, "carillon-mesh: {}\n", e.what());
    return carillon::solvers::mesher::mesher_without_storage;
  } catch (const std::exception& e) {
    fmt::print(stderr, "carillon-mesh: {}\n", e.what());
    return 1;
  }
  return 0;
}
