#include "services/model_server/knowledge_store.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/core/error.h"
#include "common/core/fault_point.h"
#include "common/core/hash.h"
#include "common/object_model/model_file.h"

namespace periplus::model {

namespace {

constexpr int kSchema = 2;  // 1: no checksums
constexpr int kMostSchemas = 9999;  // beyond, the number itself is damaged
constexpr const char* kDamaged = "the file is damaged: put back a copy, or export what periplus model list still reads and move it away";

// Throws what SQLite last said of `db`, with what a person may do about it.
[[noreturn]] void refuse(sqlite3* db) {
  const std::string message = std::string("the knowledge database refused: ") + sqlite3_errmsg(db) + "; ";
  switch (sqlite3_errcode(db) & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED: throw_error(ErrorCode::model_store, message + "another program holds it: try again when that is done");
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT: throw DamagedDatabase(message + kDamaged);
    default: throw_error(ErrorCode::model_store, message + "see that its disk is writable and not full, or that the file is undamaged (periplus model verify)");
  }
}

// A prepared statement; binds from 1 on.
class Statement {
 public:
  Statement(sqlite3* db, const char* sql) : db_(db) {
    check(sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr) == SQLITE_OK);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& text(std::string_view value) {
    check(sqlite3_bind_text64(statement_, ++bound_, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8) == SQLITE_OK);
    return *this;
  }
  Statement& blob(std::string_view value) {
    check(sqlite3_bind_blob64(statement_, ++bound_, value.data(), value.size(), SQLITE_TRANSIENT) == SQLITE_OK);
    return *this;
  }
  Statement& number(std::int64_t value) {
    check(sqlite3_bind_int64(statement_, ++bound_, value) == SQLITE_OK);
    return *this;
  }
  // True while there is a row.
  bool step() {
    const int status = sqlite3_step(statement_);
    check(status == SQLITE_ROW || status == SQLITE_DONE);
    return status == SQLITE_ROW;
  }
  std::string bytes(int column) {
    const void* data = sqlite3_column_blob(statement_, column);
    const int size = sqlite3_column_bytes(statement_, column);
    return data ? std::string(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string();
  }
  std::int64_t integer(int column) { return sqlite3_column_int64(statement_, column); }

 private:
  void check(bool good) const {
    if (!good) refuse(db_);
  }
  sqlite3* db_;
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
};

void run(sqlite3* db, const char* sql) {
  Statement statement(db, sql);
  while (statement.step()) {
  }
}

// Rolled back unless committed.
class Transaction {
 public:
  explicit Transaction(sqlite3* db) : db_(db) { run(db, "BEGIN IMMEDIATE"); }
  ~Transaction() {
    if (!done_) sqlite3_exec(db_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  void commit() {
    fault_point("store.before_commit");
    run(db_, "COMMIT");
    done_ = true;
    fault_point("store.committed");
  }

 private:
  sqlite3* db_;
  bool done_ = false;
};

// Held until the end of the process or of this.
class WriterLock {
 public:
  explicit WriterLock(const std::string& path) : file_(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    require(file_ >= 0, ErrorCode::model_store, "cannot create " + path + "; set store_folder to one that can be written");
    if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    ::close(file_);
    throw_error(ErrorCode::model_store, path + " is held by another process: a model server uses this store; stop it first, or set another store_folder");
  }
  ~WriterLock() { ::close(file_); }
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  int file_;
};

// True for a database of another user or on a medium that cannot be written, which no server uses. Throws Error if what its log holds cannot be read there.
bool is_read_only(const std::string& folder, const std::string& path) {
  if (::access(folder.c_str(), W_OK) == 0 && ::access(path.c_str(), W_OK) == 0) return false;
  std::error_code error;
  const bool used = std::filesystem::exists(path + "-shm", error);
  const auto logged = std::filesystem::file_size(path + "-wal", error);
  if (error) return true;
  require(used || logged == 0, ErrorCode::model_store,
          "a killed server left a log beside " + path + ", and the folder cannot be written; copy knowledge.sqlite and knowledge.sqlite-wal to one that can, and name that");
  return !used;
}

// The file's name for SQLite, without a log and its index beside it, which it would create.
std::string as_it_lies(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) uri += c == '%' ? "%25" : c == '?' ? "%3f" : c == '#' ? "%23" : std::string(1, c);
  return uri + "?immutable=1";
}

std::string sum_of(const EnvironmentTexts& t) {
  std::string all;
  for (const std::string* text : {&t.scene_id, &t.scene_yaml, &t.robot_yaml, &t.robot_urdf}) all += std::to_string(text->size()) + ":" + *text;
  return sha256_hex(all);
}

}  // namespace

struct KnowledgeStore::Impl {
  std::optional<WriterLock> lock;
  sqlite3* db = nullptr;
  ~Impl() { sqlite3_close(db); }

  // The views as they are kept already, or of the model.
  void put_state(const object_model::ObjectModel& model, const std::vector<std::string>& view_sums) {
    const std::string state = object_model::write_state(model, view_sums);
    fault_point("store.state_packed");
    Statement(db, "INSERT OR REPLACE INTO objects (object_id, state, sha256) VALUES (?, ?, ?)")
        .text(model.state().object_id)
        .blob(state)
        .text(sha256_hex(state))
        .step();
    fault_point("store.state_written");
  }
  // Its checksum.
  std::string put_view(const object_model::ObjectModel& model, std::size_t number) {
    const object_model::View& view = *model.state().views.at(number);
    const std::string data = object_model::write_view(view), sum = sha256_hex(data);
    fault_point("store.view_packed");
    Statement(db, "INSERT INTO views (object_id, number, view_id, view, sha256) VALUES (?, ?, ?, ?, ?)")
        .text(model.state().object_id)
        .number(static_cast<std::int64_t>(number))
        .text(view.view_id)
        .blob(data)
        .text(sum)
        .step();
    fault_point("store.view_written");
    return sum;
  }
  void put(const object_model::ObjectModel& model) {
    remove(model.state().object_id);
    std::vector<std::string> sums;
    for (std::size_t n = 0; n < model.state().views.size(); ++n) sums.push_back(put_view(model, n));
    put_state(model, sums);
  }
  bool remove(const std::string& id) {
    Statement(db, "DELETE FROM views WHERE object_id = ?").text(id).step();
    Statement(db, "DELETE FROM objects WHERE object_id = ?").text(id).step();
    return sqlite3_changes(db) > 0;
  }

  std::vector<std::string> ids() const {
    std::vector<std::string> out;
    Statement objects(db, "SELECT object_id FROM objects ORDER BY object_id");
    while (objects.step()) out.push_back(objects.bytes(0));
    return out;
  }

  // Throws Error if anything of it is damaged.
  std::optional<object_model::ObjectModel> model(const std::string& id) const {
    Statement object(db, "SELECT state, sha256 FROM objects WHERE object_id = ?");
    object.text(id);
    if (!object.step()) return std::nullopt;
    const std::string state = object.bytes(0);
    require(object.bytes(1) == sha256_hex(state), ErrorCode::model_store, "its state is damaged: the checksum does not fit");
    std::vector<std::string> views;
    Statement statement(db, "SELECT view FROM views WHERE object_id = ? ORDER BY number");
    statement.text(id);
    while (statement.step()) views.push_back(statement.bytes(0));
    object_model::ObjectModel m = object_model::read_parts(state, views);
    require(m.state().object_id == id, ErrorCode::model_store, "it is kept under another name, " + m.state().object_id);
    return m;
  }

  // Objects of schema 1, which can be read as they are and put again; one that cannot stays, without a checksum.
  void migrate() {
    run(db, "ALTER TABLE environment ADD COLUMN sha256 TEXT");
    run(db, "ALTER TABLE objects ADD COLUMN sha256 TEXT");
    run(db, "ALTER TABLE views ADD COLUMN sha256 TEXT");
    for (const std::string& id : ids()) {
      Statement object(db, "SELECT state FROM objects WHERE object_id = ?");
      object.text(id).step();
      std::vector<std::string> views;
      Statement statement(db, "SELECT view FROM views WHERE object_id = ? ORDER BY number");
      statement.text(id);
      while (statement.step()) views.push_back(statement.bytes(0));
      try {
        put(object_model::read_parts(object.bytes(0), views));
      } catch (const Error& e) {
        if (e.code() == ErrorCode::model_store) throw;
      }
    }
    if (const auto kept = environment()) put(kept->first);
  }

  // As it stands there, and its checksum.
  std::optional<std::pair<EnvironmentTexts, std::string>> environment() const {
    Statement statement(db, "SELECT scene_id, scene_yaml, robot_yaml, robot_urdf, sha256 FROM environment");
    if (!statement.step()) return std::nullopt;
    return std::pair{EnvironmentTexts{statement.bytes(0), statement.bytes(1), statement.bytes(2), statement.bytes(3)}, statement.bytes(4)};
  }
  void put(const EnvironmentTexts& texts) {
    Statement(db, "INSERT OR REPLACE INTO environment (one, scene_id, scene_yaml, robot_yaml, robot_urdf, sha256) VALUES (1, ?, ?, ?, ?, ?)")
        .text(texts.scene_id)
        .text(texts.scene_yaml)
        .text(texts.robot_yaml)
        .text(texts.robot_urdf)
        .text(sum_of(texts))
        .step();
  }
  std::int64_t schema(const std::string& path) const {
    Statement version(db, "PRAGMA user_version");
    version.step();
    const auto found = version.integer(0);
    if (found < 0 || found > kMostSchemas) throw DamagedDatabase(path + " gives no version (schema " + std::to_string(found) + "); " + kDamaged);
    require(found <= kSchema, ErrorCode::model_store,
            path + " was written by a newer version of Periplus (schema " + std::to_string(found) + "); move it away or set another store_folder");
    return found;
  }
};

KnowledgeStore::KnowledgeStore(const std::string& folder, Access access) : impl_(std::make_unique<Impl>()) {
  const std::string path = folder + "/knowledge.sqlite";
  std::error_code error;
  if (access == Access::write) {
    std::filesystem::create_directories(folder, error);
    require(!error, ErrorCode::model_store, "cannot create the folder " + folder + ": " + error.message() + "; set store_folder to one that can be written");
    impl_->lock.emplace(folder + "/knowledge.lock");
  } else {
    require(std::filesystem::exists(path, error), ErrorCode::model_store,
            "there is no " + path + "; name with --store the folder that a model server used as its store_folder (of `periplus run` and `up`: knowledge in their own folder)");
  }
  // Readers open it for writing too: what a killed server left in the log belongs to the database.
  const int flags = access == Access::write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READWRITE;
  const int status = access == Access::read && is_read_only(folder, path) ? sqlite3_open_v2(as_it_lies(path).c_str(), &impl_->db, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr)
                                                                         : sqlite3_open_v2(path.c_str(), &impl_->db, flags, nullptr);
  require(status == SQLITE_OK, ErrorCode::model_store, "cannot open " + path + ": " + sqlite3_errstr(status));
  sqlite3* db = impl_->db;
  sqlite3_busy_timeout(db, 2000);
  if (access == Access::read) {
    require(impl_->schema(path) == kSchema, ErrorCode::model_store,
            path + " was written by an older version of Periplus; start its model server once to bring it to this one's form");
    return;
  }
  run(db, "PRAGMA journal_mode = WAL");
  run(db, "PRAGMA synchronous = FULL");  // each commit reaches the disk: a power cut takes the view in flight alone
  Transaction transaction(db);
  const auto found = impl_->schema(path);
  if (found == 0) {
    run(db, "CREATE TABLE environment (one INTEGER PRIMARY KEY CHECK (one = 1), scene_id TEXT, scene_yaml TEXT, robot_yaml TEXT, robot_urdf TEXT, sha256 TEXT)");
    run(db, "CREATE TABLE objects (object_id TEXT PRIMARY KEY, state BLOB NOT NULL, sha256 TEXT)");
    run(db, "CREATE TABLE views (object_id TEXT, number INTEGER, view_id TEXT, view BLOB NOT NULL, sha256 TEXT, "
            "PRIMARY KEY (object_id, number), UNIQUE (object_id, view_id))");
  } else if (found < kSchema) {
    impl_->migrate();
  }
  run(db, ("PRAGMA user_version = " + std::to_string(kSchema)).c_str());
  transaction.commit();
}

KnowledgeStore::~KnowledgeStore() = default;

void KnowledgeStore::put_environment(const EnvironmentTexts& texts) {
  if (impl_->environment() == std::pair{texts, sum_of(texts)}) return;
  Transaction transaction(impl_->db);
  impl_->put(texts);
  transaction.commit();
}

std::optional<EnvironmentTexts> KnowledgeStore::environment() const {
  auto kept = impl_->environment();
  if (!kept) return std::nullopt;
  require(kept->second == sum_of(kept->first), ErrorCode::model_store,
          "the environment is damaged: the checksum does not fit; set it again (model/set_environment, or periplus run)");
  return std::move(kept->first);
}

void KnowledgeStore::put_model(const object_model::ObjectModel& model) {
  Transaction transaction(impl_->db);
  impl_->put(model);
  transaction.commit();
}

void KnowledgeStore::add_view(const object_model::ObjectModel& model) {
  const auto& views = model.state().views;
  require(!views.empty(), ErrorCode::internal, "a model without views has no view to add");
  Transaction transaction(impl_->db);
  fault_point("store.begun");
  std::vector<std::string> sums;
  Statement statement(impl_->db, "SELECT sha256 FROM views WHERE object_id = ? ORDER BY number");
  statement.text(model.state().object_id);
  while (statement.step()) sums.push_back(statement.bytes(0));
  require(sums.size() + 1 == views.size(), ErrorCode::internal, "the model has other views than those that are stored");
  sums.push_back(impl_->put_view(model, views.size() - 1));
  impl_->put_state(model, sums);
  transaction.commit();
}

bool KnowledgeStore::remove_model(const std::string& object_id) {
  Transaction transaction(impl_->db);
  const bool was_there = impl_->remove(object_id);
  transaction.commit();
  return was_there;
}

std::vector<object_model::ObjectModel> KnowledgeStore::models(std::vector<std::string>* damaged) const {
  std::vector<object_model::ObjectModel> out;
  for (const std::string& id : impl_->ids()) {
    try {
      if (auto m = impl_->model(id)) out.push_back(std::move(*m));
    } catch (const Error& e) {
      if (damaged) damaged->push_back(id + ": " + e.what());
    }
  }
  return out;
}

std::optional<object_model::ObjectModel> KnowledgeStore::model(const std::string& object_id) const {
  try {
    return impl_->model(object_id);
  } catch (const Error& e) {
    throw_error(ErrorCode::model_store, "object " + object_id + ": " + e.what());
  }
}

std::vector<std::string> KnowledgeStore::verify() const {
  std::vector<std::string> damaged;
  const auto attempt = [&](const auto& look) {
    try {
      look();
    } catch (const Error& e) {
      damaged.emplace_back(e.what());
    }
  };
  attempt([&] {
    Statement check(impl_->db, "PRAGMA integrity_check(20)");
    while (check.step()) {
      if (const std::string line = check.bytes(0); line != "ok") damaged.push_back("the file's structure: " + line);
    }
  });
  attempt([&] {
    // SQLite reads what claims a later format, and writes nothing to it.
    char header[20] = {};
    std::ifstream(sqlite3_db_filename(impl_->db, "main"), std::ios::binary).read(header, sizeof header);
    if (const int format = static_cast<unsigned char>(header[18]); format > 2) throw DamagedDatabase("the file's header: a format of version " + std::to_string(format) + "; " + kDamaged);
  });
  attempt([&] { environment(); });
  attempt([&] {
    Statement lost(impl_->db, "SELECT DISTINCT object_id FROM views WHERE object_id NOT IN (SELECT object_id FROM objects)");
    while (lost.step()) damaged.push_back("views of an object that is not there: " + lost.bytes(0));
  });
  attempt([&] {
    std::vector<std::string> of_models;
    for (const object_model::ObjectModel& m : models(&of_models)) {
      const auto& s = m.state();
      if (s.imported || s.views.empty()) continue;
      const object_model::Integration& last = s.views.back()->result;
      if (last.revision != s.grid.revision || !(last.counts == s.grid.counts())) damaged.push_back(s.object_id + ": its grid is not the one that its last view gave");
    }
    damaged.insert(damaged.end(), of_models.begin(), of_models.end());
  });
  return damaged;
}

}  // namespace periplus::model
