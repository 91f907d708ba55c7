// `periplus model`: the knowledge database, without DDS. README.md, "On the database".
#include <CLI/CLI.hpp>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/locate.h"
#include "common/core/version.h"
#include "common/object_model/model_export.h"
#include "common/object_model/model_file.h"
#include "common/object_model/model_import.h"
#include "common/scene/scene.h"
#include "services/model_server/knowledge_store.h"
#include "services/model_server/settings.h"
#include "services/model_server/tool/model_text.h"

namespace {

using namespace periplus;
using namespace periplus::model;
using object_model::ObjectModel;

struct Options {
  std::string store, object, format = "ply", output, file, config, name;
  std::vector<std::string> without;
  double voxel_m = 0.01;
  bool json = false, yes = false, replace = false, recarve = false;
};

std::string store_folder(const Options& o) {
  if (!o.store.empty()) return o.store;
  const char* domain = std::getenv("PERIPLUS_DOMAIN");
  return default_store_folder(domain && *domain ? std::atoi(domain) : 42);
}

KnowledgeStore reading(const Options& o) { return KnowledgeStore(store_folder(o), KnowledgeStore::Access::read); }

// The server's own configuration: what it carves with.
object_model::CarvingSettings carving(const Options& o) {
  const std::filesystem::path file = o.config.empty() ? default_configuration("model_server") : std::filesystem::path(o.config);
  return file.empty() ? object_model::CarvingSettings() : read_settings(config::load_file(file.string())).carving;
}

ObjectModel the_model(const KnowledgeStore& store, const std::string& id) {
  std::vector<std::string> damaged;
  if (!id.empty()) {
    auto m = store.model(id);
    require(m.has_value(), ErrorCode::bad_input, "no object " + id + " is stored; `periplus model list` names them");
    return std::move(*m);
  }
  std::vector<ObjectModel> all = store.models(&damaged);
  require(damaged.empty(), ErrorCode::bad_input, "which object? one is damaged: `periplus model verify`");
  require(all.size() == 1, ErrorCode::bad_input, all.empty() ? "no object is stored" : "which object? `periplus model list` names them");
  return std::move(all.front());
}

void note(ObjectModel& m, const std::string& what, const std::string& detail) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  m.note({std::chrono::duration_cast<std::chrono::nanoseconds>(now).count(), what, detail, m.grid().revision, version()});
}

int list(const Options& o) {
  const KnowledgeStore store = reading(o);
  std::vector<std::string> damaged;
  const auto models = store.models(&damaged);
  std::cout << (o.json ? list_json(models).dump(2) + "\n" : list_text(models));
  for (const std::string& d : damaged) std::cerr << "periplus model: damaged: " << d << "\n";
  return damaged.empty() ? 0 : 1;
}

int show(const Options& o) {
  const KnowledgeStore store = reading(o);
  const ObjectModel m = the_model(store, o.object);
  std::cout << (o.json ? show_json(m).dump(2) + "\n" : show_text(m));
  return 0;
}

int digest(const Options& o) {
  const KnowledgeStore store = reading(o);
  const ObjectModel m = the_model(store, o.object);
  std::cout << m.digest() << "  " << m.state().object_id << "\n";
  return 0;
}

// What is there stays whole if the disk is full: beside it first, through links. A device or pipe (/dev/stdout) is written to, not replaced;
// false then.
bool write_file(const std::string& file, const std::string& data) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status there = fs::status(file, error);
  const bool replaces = !fs::exists(there) || fs::is_regular_file(there);
  const std::string target = fs::is_regular_file(there) ? fs::canonical(file, error).string() : file, written = replaces ? target + ".part" : target;
  std::ofstream out(written, std::ios::binary);
  out.write(data.data(), static_cast<std::streamsize>(data.size()));
  out.close();
  error.clear();
  if (!out.fail() && replaces) fs::rename(written, target, error);
  if (!out.fail() && !error) return replaces;
  if (replaces) fs::remove(written, error);
  throw_error(ErrorCode::io, "cannot write " + file + "; choose another with --output");
}

int export_to_file(const Options& o) {
  const KnowledgeStore store = reading(o);
  const ObjectModel m = the_model(store, o.object);
  const std::string data = object_model::export_model(m, o.format, carving(o));
  std::string file = o.output;
  if (file.empty()) {
    for (const object_model::ExportFormat& f : object_model::export_formats())
      if (o.format == f.name) file = m.state().object_id + f.extension;
  }
  (write_file(file, data) ? std::cout : std::cerr) << file << ": " << data.size() << " bytes\n";
  return 0;
}

// As the services want it.
void check_name(const std::string& id) {
  require(!id.empty() && id.size() <= 64 && id != "." && id != ".." &&
              id.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-") == std::string::npos,
          ErrorCode::bad_input, "an object's name has 1 to 64 letters, digits, dots, dashes and underscores; choose one with --name");
}

int import_file(const Options& o) {
  const std::filesystem::path path = o.file;
  const std::string id = o.name.empty() ? path.stem().string() : o.name;
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".periplus" || !o.name.empty()) check_name(id);
  const std::string data = read_file(o.file);
  ObjectModel m = [&] {
    if (extension == ".periplus") {
      ObjectModel read = object_model::read_model(data);
      if (o.name.empty() || read.state().object_id == id) return read;
      object_model::ModelState renamed = read.state();
      renamed.object_id = id;
      return ObjectModel(std::move(renamed));
    }
    if (extension == ".bt") return object_model::import_bt(data, id);
    if (extension == ".pcd") return object_model::import_pcd(data, id, o.voxel_m);
    throw_error(ErrorCode::bad_input, "the file's name must end in .periplus, .bt or .pcd");
  }();
  check_name(m.state().object_id);  // the file's own may be any text
  KnowledgeStore store(store_folder(o));
  bool there = true;
  try {
    there = store.model(m.state().object_id).has_value();
  } catch (const Error&) {  // damaged, and there
  }
  require(!there || o.replace, ErrorCode::bad_input, "an object " + m.state().object_id + " is stored already; give another --name, or --replace");
  note(m, "imported", path.filename().string());
  store.put_model(m);
  std::cout << list_text({m});
  return 0;
}

object_model::Surroundings surroundings_of(const KnowledgeStore& store) {
  const auto texts = store.environment();
  require(texts.has_value(), ErrorCode::model_environment_missing, "the database holds no environment to carve in");
  const scene::Scene scene = scene::parse_scene(texts->scene_yaml, texts->scene_id);
  return {scene::environment_revision(*texts), std::make_shared<const scene::CollisionWorld>(scene), object_model::occluders_of(scene)};
}

int verify(const Options& o) {
  const KnowledgeStore store = reading(o);
  std::vector<std::string> damaged = store.verify();
  std::string carved;
  if (o.recarve && damaged.empty()) {
    // Imported models may be all that is there.
    const object_model::Surroundings around = store.environment() ? surroundings_of(store) : object_model::Surroundings();
    for (const ObjectModel& m : store.models()) {
      if (!m.can_be_revised() || !around.collision || m.state().environment_revision != around.revision) {
        carved += "  " + m.state().object_id + ": cannot be carved again here\n";
      } else if (m.revised({}, {}, around, carving(o)).digest() == m.digest()) {
        carved += "  " + m.state().object_id + ": carved again, the same grid\n";
      } else {
        damaged.push_back(m.state().object_id + ": carved again its views give another grid; was it carved with another configuration?");
      }
    }
  }
  for (const std::string& d : damaged) std::cout << "damaged: " << d << "\n";
  if (!damaged.empty()) return 1;
  std::cout << "all sound\n" << carved;
  return 0;
}

int delete_model(const Options& o) {
  require(o.yes, ErrorCode::bad_input, "this deletes " + o.object + " with all its views for good; say --yes, or keep it with `periplus model export " + o.object + " --format periplus`");
  KnowledgeStore store(store_folder(o));
  require(store.remove_model(o.object), ErrorCode::bad_input, "no object " + o.object + " is stored; `periplus model list` names them");
  std::cout << o.object << " is deleted\n";
  return 0;
}

int take_out(const Options& o) {
  KnowledgeStore store(store_folder(o));
  ObjectModel m = the_model(store, o.object).revised({}, o.without, surroundings_of(store), carving(o));
  for (const std::string& id : o.without) note(m, "view taken out", id);
  store.put_model(m);
  std::cout << list_text({m});
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The knowledge database of a model server: what stands in it. No server needs to run; those that change it need it not to run.");
  app.name("periplus model");
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("periplus ") + version());
  Options o;
  int status = 0;
  const auto verb = [&](const char* name, const char* what, int (*run)(const Options&)) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option("--store", o.store, "the server's store_folder; default: that of PERIPLUS_DOMAIN");
    sub->callback([&, run] { status = run(o); });
    return sub;
  };
  const auto with_object = [&](CLI::App* sub, bool required = false) { sub->add_option("object", o.object, "object's id; default: the only one")->required(required); };
  const auto with_config = [&](CLI::App* sub) { sub->add_option("--config", o.config, "the model server's configuration, instead of the installed one"); };

  verb("list", "all objects, a line each", list)->add_flag("--json", o.json, "print JSON");
  CLI::App* sub = verb("show", "one object: box, grid, views, history", show);
  with_object(sub);
  sub->add_flag("--json", o.json, "print JSON");
  sub = verb("export", "write it to a file", export_to_file);
  with_object(sub);
  with_config(sub);
  std::string formats;
  for (const object_model::ExportFormat& f : object_model::export_formats()) formats += (formats.empty() ? "" : ", ") + std::string(f.name);
  sub->add_option("--format", o.format, formats + " (ply)");
  sub->add_option("-o,--output", o.output, "file to write; default: <object>.<extension>");
  sub = verb("import", "take in a .periplus, .bt or .pcd", import_file);
  sub->add_option("file", o.file, "the file")->required();
  sub->add_option("--name", o.name, "object's id; default: the file's");
  sub->add_option("--voxel", o.voxel_m, "side of a voxel for .pcd [m] (0.01)");
  sub->add_flag("--replace", o.replace, "in place of an object of that name");
  sub = verb("verify", "look for damage: structure, checksums, contents", verify);
  with_config(sub);
  sub->add_flag("--recarve", o.recarve, "carve each object again from its depth maps and compare");
  sub = verb("take-out", "carve an object again without some of its views", take_out);
  with_object(sub, true);
  sub->add_option("view", o.without, "views to leave out")->required();
  with_config(sub);
  sub = verb("delete", "an object with all its views, for good", delete_model);
  with_object(sub, true);
  sub->add_flag("--yes", o.yes, "without asking");
  with_object(verb("digest", "SHA-256 over grid, views' poses and features", digest));
  app.footer("Exit status: 0, 1 if something is damaged, 2 what the caller can mend.");
  try {
    app.parse(argc, argv);
    return status;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const DamagedDatabase& e) {
    std::cerr << "periplus model: damaged: " << e.what() << std::endl;
    return 1;
  } catch (const Error& e) {
    std::cerr << "periplus model: " << e.what() << std::endl;
    return e.code() == ErrorCode::internal ? 1 : 2;
  } catch (const std::exception& e) {
    std::cerr << "periplus model: " << e.what() << std::endl;
    return 1;
  }
}
