// periplus-fuzz-replay CORPORA [--mutations N] [TARGET...]: what stands in CORPORA/<target>/ and N mutations of each file go through the
// targets, without a fuzzer. Exit status 1 and the input as a file in the working folder at the first finding; 1 too where an input whose name
// begins with neither "found-" nor "refused-" is refused.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/hash.h"
#include "integration-tests/fuzz/expected_refusal.h"
#include "integration-tests/fuzz/mutation.h"

#define PERIPLUS_FUZZ_TARGET(name) extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size);
#include "fuzz_targets.inc"
#undef PERIPLUS_FUZZ_TARGET

namespace {

namespace fs = std::filesystem;
using namespace periplus;

struct Target {
  const char* name;
  int (*run)(const std::uint8_t*, std::size_t);
};
constexpr Target kTargets[] = {
#define PERIPLUS_FUZZ_TARGET(name) {#name, fuzz_##name},
#include "fuzz_targets.inc"
#undef PERIPLUS_FUZZ_TARGET
};

constexpr std::string_view kFound = "found-", kRefused = "refused-";  // inputs that a fuzzer found, or that are to be refused
constexpr double kMostSeconds = 10;       // an input, as for the fuzzers
constexpr long kMostKilobytes = 2 << 20;  // of the whole program

std::string current, origin;

void keep_input() {
  const std::string name = "finding-" + sha256_hex(current).substr(0, 16);
  if (std::FILE* file = std::fopen(name.c_str(), "wb")) {
    std::fwrite(current.data(), 1, current.size(), file);
    std::fclose(file);
  }
  std::fprintf(stderr, "%s: a finding; the input is kept as %s\n", origin.c_str(), name.c_str());
}

// The program ends here in any case: what is not safe in a signal handler cannot make it worse.
void on_signal(int number) {
  std::signal(number, SIG_DFL);
  keep_input();
  std::raise(number);
}

void run(const Target& target, std::string input, std::string whence) {
  current = std::move(input);
  origin = std::move(whence);
  const auto start = std::chrono::steady_clock::now();
  try {
    // A copy of its own size, so that a sanitizer sees what reads beyond it.
    const std::vector<std::uint8_t> octets(current.begin(), current.end());
    target.run(octets.data(), octets.size());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    keep_input();
    std::exit(1);
  }
  if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > kMostSeconds) {
    std::fprintf(stderr, "over 10 s\n");
    keep_input();
    std::exit(1);
  }
}

void replay(const Target& target, const std::string& folder, int mutations) {
  std::vector<std::string> names, inputs;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) inputs.push_back(read_file(folder + "/" + name, std::uint64_t{1} << 20));
  require(!inputs.empty(), ErrorCode::bad_input, folder + " holds no inputs");
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    fuzz::accepted = 0;
    run(target, inputs[i], std::string(target.name) + "/" + names[i]);
    // A corpus of refused inputs fuzzes nothing but the first check.
    require(fuzz::accepted > 0 || names[i].starts_with(kFound) || names[i].starts_with(kRefused), ErrorCode::bad_input,
            origin + " is refused (" + fuzz::refusal + "); write a seed that is read (README.md), or name it " + std::string(kRefused) + "... if it is to be refused");
    Random random(i + 1);
    for (int n = 0; n < mutations; ++n)
      run(target, fuzz::mutated(inputs[i], inputs[random.below(inputs.size())], random), std::string(target.name) + "/" + names[i] + ", mutation " + std::to_string(n));
  }
  std::printf("%s: %zu inputs, %d mutations each, %.1f s\n", target.name, inputs.size(), mutations,
              std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: periplus-fuzz-replay CORPORA [--mutations N] [TARGET...]\n");
    return 2;
  }
  int mutations = 500;
  std::vector<std::string> wanted;
  for (int i = 2; i < argc; ++i) {
    if (std::strcmp(argv[i], "--mutations") == 0 && i + 1 < argc)
      mutations = std::atoi(argv[++i]);
    else
      wanted.emplace_back(argv[i]);
  }
  for (const int number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(number, on_signal);
  try {
    for (const Target& target : kTargets)
      if (wanted.empty() || std::find(wanted.begin(), wanted.end(), target.name) != wanted.end()) replay(target, std::string(argv[1]) + "/" + target.name, mutations);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  if (usage.ru_maxrss > kMostKilobytes) {
    std::fprintf(stderr, "over 2 GB of memory: %ld KiB\n", usage.ru_maxrss);
    return 1;
  }
  return 0;
}
