#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/version.h"
#include "common/core/locate.h"
#include "services/supervisor/cli/commands.h"
#include "services/supervisor/cli/run_command.h"
#include "services/supervisor/state_table.h"

int main(int argc, char** argv) {
  using namespace periplus;
  using namespace periplus::supervisor;

  CLI::App app("periplus: has a robot walk around an unknown object and build its 3D model.\n\n"
               "`periplus X` runs the program periplus-X for any other X: `periplus nbv` plans a view from files alone,\n"
               "`periplus calibrate` calibrates cameras from images of a chessboard.\n"
               "The environment chooses the bus: PERIPLUS_DOMAIN (42), PERIPLUS_DDS (fastdds | cyclonedds), PERIPLUS_INTERFACE (lo),\n"
               "PERIPLUS_PEERS.");
  app.name("periplus");
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("periplus ") + version());
  std::string domain;
  app.add_option("--domain", domain, "DDS domain, 0 to 101, instead of PERIPLUS_DOMAIN");
  int status = 0;

  cli::UpOptions up;
  CLI::App* verb = app.add_subcommand("up", "start all services and keep them running");
  verb->add_option("task", up.task, "task file whose robot and scene to use; default: the demo's");
  verb->add_flag("-d,--detach", up.detach, "in the background; returns when all are ready");
  verb->add_option("--set", up.overrides, "key=value, into the task; may be repeated")->take_all()->allow_extra_args(false);
  verb->add_option("-o,--output", up.output, "folder for logs, instead of the task's");
  verb->callback([&] { status = cli::up(up); });

  app.add_subcommand("down", "stop what `up` keeps running on this domain")->callback([&] { status = cli::down(); });

  cli::RunOptions run;
  verb = app.add_subcommand("run", "take a task from start to end; starts the services if nobody is on the domain");
  verb->add_option("task", run.task, "task file")->required();
  verb->add_flag("--check", run.check, "only read and check task, scene and robot");
  verb->add_flag("--attach", run.attach, "never start services: wait for those of the domain");
  verb->add_option("--set", run.overrides, "key=value, into the task; may be repeated")->take_all()->allow_extra_args(false);
  verb->add_option("-o,--output", run.output, "folder of the run folders, instead of the task's");
  verb->callback([&] { status = cli::run_task(run); });

  app.add_subcommand("status", "who is on the domain, and how long their calls take")->callback([&] { status = cli::show_status(); });
  app.add_subcommand("watch", "follow the run under way")->callback([&] { status = cli::watch(); });

  std::string run_id;
  verb = app.add_subcommand("abort", "end the run under way, the robot is left standing");
  verb->add_option("run", run_id, "only if it is this one");
  verb->callback([&] { status = cli::abort_run(run_id); });

  std::string object, format = "ply", output;
  CLI::App* model = app.add_subcommand("model", "the model that the model server keeps\n`periplus model list|show|verify|import|delete|take-out`, or any with --store: on its database, as periplus-model");
  model->require_subcommand(1);
  verb = model->add_subcommand("export", "write it to a file");
  verb->add_option("object", object, "object's id; default: the only one");
  verb->add_option("--format", format, "periplus, ply (default), obj, glb, points.ply, pcd, bt, ot or features.csv");
  verb->add_option("-o,--output", output, "file to write; default: <object>.<format>");
  verb->callback([&] { status = cli::export_model(object, format, output); });
  verb = model->add_subcommand("digest", "SHA-256 over grid, views and features");
  verb->add_option("object", object, "object's id; default: the only one");
  verb->callback([&] { status = cli::print_digest(object); });

  std::string run_folder, pictures, figures, azimuth;
  verb = app.add_subcommand("report", "write report.html of a run");
  verb->add_option("run", run_folder, "the run's folder, or its name below runs/")->required();
  verb->add_option("--pictures", pictures, "folder for pictures of a look and of the model");
  verb->add_option("--figures", figures, "folder for figures: the robot in all its postures, what is still unknown, the model after each look");
  verb->add_option("--azimuth", azimuth, "where the figures are taken from, degrees from +x to +y; default: where most robots are seen");
  verb->callback([&] {
    std::vector<std::string> options;
    if (!pictures.empty()) options.insert(options.end(), {"--pictures", pictures});
    if (!figures.empty()) options.insert(options.end(), {"--figures", figures});
    if (!azimuth.empty()) options.insert(options.end(), {"--azimuth", azimuth});
    status = cli::make_report(run_folder, options);
  });

  bool clean = false;
  verb = app.add_subcommand("doctor", "check libraries, shared memory, socket buffers, clocks, and who is on the domain");
  verb->add_flag("--clean", clean, "remove what killed processes left in shared memory");
  verb->callback([&] { status = cli::doctor(clean); });

  app.add_subcommand("states", "the supervisor's state machine for Graphviz")->callback([] { std::cout << states_dot(); });
  app.add_subcommand("version", "print the version")->callback([] { std::cout << "periplus " << version() << "\n"; });

  log::configure({.service = "periplus", .file = "", .level = log::Level::warn, .console = true});
  try {
    if (argc > 1 && argv[1][0] != '-') {
      const std::string name = argv[1];
      if (cli::is_of_database({argv + 1, argv + argc})) {
        const auto program = cli::find_program("model", executable_folder());
        require(!program.empty(), ErrorCode::io, "periplus-model is not installed beside this program; install the package periplus-model-server");
        ::execv(program.c_str(), argv + 1);
      }
      std::vector<std::string> verbs;
      for (const CLI::App* known : app.get_subcommands([](const CLI::App*) { return true; })) verbs.push_back(known->get_name());
      if (std::find(verbs.begin(), verbs.end(), name) == verbs.end()) {
        const auto program = cli::find_program(name, executable_folder());
        if (!program.empty()) ::execv(program.c_str(), argv + 1);
        std::cerr << cli::no_such_command(name, verbs) << std::endl;
        return 2;
      }
    }
    // The option stands before the verb, whose callback already joins the bus.
    app.parse_complete_callback([&] {
      if (!domain.empty()) ::setenv("PERIPLUS_DOMAIN", domain.c_str(), 1);
    });
    app.parse(argc, argv);
    return status;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const Error& e) {
    std::cerr << "periplus: " << e.what() << std::endl;
    return cli::exit_status_of(e.code());
  } catch (const std::exception& e) {
    std::cerr << "periplus: " << e.what() << std::endl;
    return 1;
  }
}
