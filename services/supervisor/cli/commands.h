// The verbs of `periplus` that look and ask; those that run things are in run_command.h.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/core/error.h"

namespace periplus::supervisor::cli {

int show_status();
int watch();
int abort_run(const std::string& run_id);
int export_model(const std::string& object_id, const std::string& format, const std::string& output);
int print_digest(const std::string& object_id);
// `options` as periplus-report takes them.
int make_report(const std::string& run, const std::vector<std::string>& options = {});
int doctor(bool clean);

// Exit status of an error: 2 what the caller can mend, 5 a service lost, 130 cancelled, 1 otherwise.
int exit_status_of(ErrorCode code);

// `periplus X …` runs the program periplus-X found in `folder` or on the PATH, as git does. Empty if there is none.
std::filesystem::path find_program(const std::string& verb, const std::filesystem::path& folder);
// Whether `periplus model …` asks for the database's program: all its verbs but export and digest, and these where --store is said. The two
// ask the model server otherwise, wherever it runs.
bool is_of_database(const std::vector<std::string>& arguments);
// "periplus: there is no command 'staus'; did you mean 'status'?"
std::string no_such_command(const std::string& verb, const std::vector<std::string>& verbs);
// The run's folder by path, or by name below ./runs. Throws Error(bad_input).
std::filesystem::path find_run(const std::string& run);

}  // namespace periplus::supervisor::cli
