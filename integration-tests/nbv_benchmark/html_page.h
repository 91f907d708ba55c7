// A report (report.h) as one page for people: plots, tables, how it was made. Needs no network and no script.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace periplus::nbv_benchmark {

std::string html_page(const nlohmann::json& report);

}  // namespace periplus::nbv_benchmark
