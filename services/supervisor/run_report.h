// report.html: one file that opens offline, from a run's folder (report.json, scene.yaml, looks/, model.ply).
#pragma once

#include <string>

namespace periplus::supervisor {

// Error(io | bad_input) if the folder holds no report that can be read; missing pictures are left out.
std::string html_report(const std::string& run_folder);
// Writes it as run_folder/report.html.
void write_html_report(const std::string& run_folder);

}  // namespace periplus::supervisor
