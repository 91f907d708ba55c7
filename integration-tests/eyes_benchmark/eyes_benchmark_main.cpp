// periplus-eyes-benchmark: stereo, normals and carving against the truth. README.md says what is measured and how.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/core/locate.h"
#include "integration-tests/eyes_benchmark/report.h"
#include "services/model_server/settings.h"
#include "services/vision_server/image_memory.h"
#include "services/vision_server/settings.h"

namespace {

namespace fs = std::filesystem;
using namespace periplus;
using namespace periplus::eyes_benchmark;

struct Arguments {
  std::string output = "runs/eyes-benchmark", vision_config, model_config;
  std::vector<std::string> objects, vision_set;
  std::uint64_t seed = 1;
  int threads = 2;
  bool check = false, no_real = false, no_features = false;
};

BenchmarkOptions options_of(const Arguments& a) {
  BenchmarkOptions o;
  config::Node vision = config::load_file(a.vision_config.empty() ? default_configuration("vision_server").string() : a.vision_config);
  for (const std::string& change : a.vision_set) {
    const std::size_t equal = change.find('=');
    require(equal != std::string::npos && equal > 0, ErrorCode::bad_input, "--vision-set wants dotted.key=value, not " + change);
    config::set(vision, change.substr(0, equal), change.substr(equal + 1));
  }
  o.perceive = vision::read_settings(vision).perceive;
  o.carving = model::read_settings(config::load_file(a.model_config.empty() ? default_configuration("model_server").string() : a.model_config)).carving;
  for (const std::string& name : a.objects)
    require(std::find(o.objects.begin(), o.objects.end(), name) != o.objects.end(), ErrorCode::bad_input,
            "there is no object '" + name + "'; there are: bunny elephant triceratops mug");
  if (!a.objects.empty()) o.objects = a.objects;
  o.sensor.seed = a.seed;
  o.threads = a.threads;
  o.real = !a.no_real;
  o.features = !a.no_features;
  o.pictures = a.output + "/pictures";
  return o;
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  require(file.good(), ErrorCode::io, "cannot write " + path.string());
}

int run(const Arguments& a, const std::string& command) {
  const BenchmarkOptions o = options_of(a);
  fs::create_directories(o.pictures);
  const BenchmarkResult r = run_benchmark(o, [](const std::string& s) { std::fprintf(stderr, "%s\n", s.c_str()); });
  const std::vector<Check> checks = check_limits(r, o.objects, o.real, o.features);
  const nbv_benchmark::Provenance made = nbv_benchmark::provenance(command);
  const fs::path folder = a.output;
  write(folder / "benchmark.json", to_json(r, o, checks, made).dump(1) + "\n");
  write(folder / "benchmark.csv", to_csv(r));
  write(folder / "index.md", to_markdown(r, o, checks, made, "pictures/"));
  std::printf("%s\n%s/index.md, benchmark.json, benchmark.csv, pictures\n", to_markdown(r, o, checks, made, "").c_str(), a.output.c_str());
  return !a.check || std::all_of(checks.begin(), checks.end(), [](const Check& c) { return c.ok || !c.judged; }) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  periplus::vision::keep_image_memory();  // as the vision server does
  CLI::App app{"Stereo, normals and carving against the truth; integration-tests/eyes_benchmark/README.md"};
  Arguments a;
  app.add_option("--output", a.output, "folder of the results");
  app.add_option("--vision-config", a.vision_config, "parameters (YAML of vision_server)");
  app.add_option("--vision-set", a.vision_set, "one of them: dotted.key=value");
  app.add_option("--model-config", a.model_config, "parameters (YAML of model_server)");
  app.add_option("--objects", a.objects, "only these")->delimiter(',');
  app.add_option("--seed", a.seed, "of noise and samples");
  app.add_option("--threads", a.threads, "of OpenCV; results do not depend on it");
  app.add_flag("--no-real", a.no_real, "without Aloe and Motorcycle");
  app.add_flag("--no-features", a.no_features, "without places, matches and landmarks by kind of feature");
  app.add_flag("--check", a.check, "exit status 1 if a limit is missed");
  CLI11_PARSE(app, argc, argv);
  std::string command;
  for (int i = 1; i < argc; ++i) command += std::string(i > 1 ? " " : "") + argv[i];
  try {
    return run(a, command);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "periplus-eyes-benchmark: %s\n", e.what());
  }
  return 2;
}
