#include "integration-tests/nbv_benchmark/kept.h"

#include "integration-tests/nbv_benchmark/benchmark.h"

namespace periplus::nbv_benchmark {

KeptRun::KeptRun(const std::string& folder, const Setting&, const Arena&, const Subject&, const std::string&) : folder_(folder) {}
void KeptRun::add(const ViewRecord&, const Look&) {}
void KeptRun::finish(const Run&) {}

}  // namespace periplus::nbv_benchmark
