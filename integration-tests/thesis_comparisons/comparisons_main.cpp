// periplus-thesis-comparisons: the comparisons of thesis 3.4.1 to 3.4.5 run again; README.md says what is compared and how.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "integration-tests/thesis_comparisons/page.h"

namespace {

namespace fs = std::filesystem;
using namespace periplus;
using namespace periplus::thesis_comparisons;

const std::string kRoot = PERIPLUS_SOURCE_DIR;

void write(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  require(file.good(), ErrorCode::io, "cannot write " + path.string());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"The comparisons of thesis 3.4.1 to 3.4.5 run again; integration-tests/thesis_comparisons/README.md"};
  std::string catalogue = kRoot + "/integration-tests/nbv_benchmark/config/objects.yaml", robot = kRoot + "/deploy/robots/hrp2like.yaml";
  std::string output = "runs/thesis-comparisons";
  bool quick = false;
  ComparisonOptions o;
  app.add_option("--catalogue", catalogue, "the fetched objects (YAML)");
  app.add_option("--robot", robot, "robot YAML, its URDF beside it");
  app.add_option("--output", output, "folder of the page, the figures and the JSON");
  app.add_option("--seed", o.seed);
  app.add_option("--threads", o.threads, "results do not depend on it");
  app.add_flag("--quick", quick, "two fetched objects, coarse: to see that it runs");
  CLI11_PARSE(app, argc, argv);
  std::string command;
  for (int i = 1; i < argc; ++i) command += std::string(i > 1 ? " " : "") + argv[i];
  try {
    o.files = nbv_benchmark::read_catalogue(catalogue);
    o.robot = robot::RobotModel::load_files(fs::path(robot).replace_extension(".urdf"), robot);
    if (quick) {
      o.files.resize(std::min<std::size_t>(o.files.size(), 2));
      o.voxels = 24;
      o.starts = 1;
      o.line_steps = 11;
      o.large_voxels = 24;
      o.large_objects = 1;
      o.large_seeds = 1;
      o.large_views = 4;
      o.large_evaluations = 150;
    }
    const Comparisons c = run_comparisons(o, [](const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); });
    const nbv_benchmark::Provenance made = nbv_benchmark::provenance(command);
    const fs::path folder = output;
    fs::create_directories(folder / "thesis-comparisons");
    for (const Figure& f : figures(c)) write(folder / "thesis-comparisons" / f.file, f.svg);
    write(folder / "thesis-comparisons" / "comparisons.json", to_json(c, o, made).dump(1) + "\n");
    write(folder / "thesis-comparisons.md", page(c, o, made, "thesis-comparisons"));
    for (const Claim& claim : claims(c)) std::printf("%-26s %-9s %s\n", claim.section.c_str(), to_string(claim.verdict), claim.here.c_str());
    std::printf("%s/thesis-comparisons.md\n", output.c_str());
    return 0;
  } catch (const Error& e) {
    std::fprintf(stderr, "periplus-thesis-comparisons: %s\n", e.what());
  } catch (const std::exception& e) {
    std::fprintf(stderr, "periplus-thesis-comparisons: %s\n", e.what());
  }
  return 2;
}
