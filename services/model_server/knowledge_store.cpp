#include "services/model_server/knowledge_store.h"

#include <sqlite3.h>

#include <filesystem>

#include "common/core/error.h"
#include "common/object_model/model_file.h"

namespace periplus::model {

namespace {

constexpr int kSchema = 1;

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
    require(good, ErrorCode::model_store,
            std::string("the knowledge database refused: ") + sqlite3_errmsg(db_) +
                "; see that its disk is writable and not full, and that no other model server uses the same store_folder");
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
    run(db_, "COMMIT");
    done_ = true;
  }

 private:
  sqlite3* db_;
  bool done_ = false;
};

}  // namespace

struct KnowledgeStore::Impl {
  sqlite3* db = nullptr;
  ~Impl() { sqlite3_close(db); }

  void put_state(const object_model::ObjectModel& model) {
    Statement(db, "INSERT OR REPLACE INTO objects (object_id, state) VALUES (?, ?)")
        .text(model.state().object_id)
        .blob(object_model::write_state(model))
        .step();
  }
  void put_view(const object_model::ObjectModel& model, std::size_t number) {
    const object_model::View& view = *model.state().views.at(number);
    Statement(db, "INSERT INTO views (object_id, number, view_id, view) VALUES (?, ?, ?, ?)")
        .text(model.state().object_id)
        .number(static_cast<std::int64_t>(number))
        .text(view.view_id)
        .blob(object_model::write_view(view))
        .step();
  }
};

KnowledgeStore::KnowledgeStore(const std::string& folder) : impl_(std::make_unique<Impl>()) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  require(!error, ErrorCode::model_store, "cannot create the folder " + folder + ": " + error.message() + "; set store_folder to one that can be written");
  const std::string path = folder + "/knowledge.sqlite";
  const int status = sqlite3_open_v2(path.c_str(), &impl_->db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  require(status == SQLITE_OK, ErrorCode::model_store, "cannot open " + path + ": " + sqlite3_errstr(status));
  sqlite3* db = impl_->db;
  sqlite3_busy_timeout(db, 2000);
  // Exclusive: no shared-memory file beside the log, and a second server on the same file is refused.
  run(db, "PRAGMA locking_mode = EXCLUSIVE");
  run(db, "PRAGMA journal_mode = WAL");
  run(db, "PRAGMA synchronous = NORMAL");
  Transaction transaction(db);
  Statement version(db, "PRAGMA user_version");
  version.step();
  const auto found = version.integer(0);
  require(found == 0 || found == kSchema, ErrorCode::model_store,
          path + " was written by another version of Periplus (schema " + std::to_string(found) + "); move it away or set another store_folder");
  run(db, "CREATE TABLE IF NOT EXISTS environment (one INTEGER PRIMARY KEY CHECK (one = 1), scene_id TEXT, scene_yaml TEXT, robot_yaml TEXT, robot_urdf TEXT)");
  run(db, "CREATE TABLE IF NOT EXISTS objects (object_id TEXT PRIMARY KEY, state BLOB NOT NULL)");
  run(db, "CREATE TABLE IF NOT EXISTS views (object_id TEXT, number INTEGER, view_id TEXT, view BLOB NOT NULL, "
          "PRIMARY KEY (object_id, number), UNIQUE (object_id, view_id))");
  run(db, "PRAGMA user_version = 1");
  transaction.commit();
}

KnowledgeStore::~KnowledgeStore() = default;

void KnowledgeStore::put_environment(const EnvironmentTexts& texts) {
  Transaction transaction(impl_->db);
  Statement(impl_->db, "INSERT OR REPLACE INTO environment VALUES (1, ?, ?, ?, ?)")
      .text(texts.scene_id)
      .text(texts.scene_yaml)
      .text(texts.robot_yaml)
      .text(texts.robot_urdf)
      .step();
  transaction.commit();
}

std::optional<EnvironmentTexts> KnowledgeStore::environment() const {
  Statement statement(impl_->db, "SELECT scene_id, scene_yaml, robot_yaml, robot_urdf FROM environment");
  if (!statement.step()) return std::nullopt;
  return EnvironmentTexts{statement.bytes(0), statement.bytes(1), statement.bytes(2), statement.bytes(3)};
}

void KnowledgeStore::put_model(const object_model::ObjectModel& model) {
  Transaction transaction(impl_->db);
  Statement(impl_->db, "DELETE FROM views WHERE object_id = ?").text(model.state().object_id).step();
  impl_->put_state(model);
  for (std::size_t n = 0; n < model.state().views.size(); ++n) impl_->put_view(model, n);
  transaction.commit();
}

void KnowledgeStore::add_view(const object_model::ObjectModel& model) {
  require(!model.state().views.empty(), ErrorCode::internal, "a model without views has no view to add");
  Transaction transaction(impl_->db);
  impl_->put_state(model);
  impl_->put_view(model, model.state().views.size() - 1);
  transaction.commit();
}

std::vector<object_model::ObjectModel> KnowledgeStore::models(std::vector<std::string>* damaged) const {
  std::vector<object_model::ObjectModel> out;
  Statement objects(impl_->db, "SELECT object_id, state FROM objects ORDER BY object_id");
  while (objects.step()) {
    const std::string id = objects.bytes(0);
    std::vector<std::string> views;
    Statement statement(impl_->db, "SELECT view FROM views WHERE object_id = ? ORDER BY number");
    statement.text(id);
    while (statement.step()) views.push_back(statement.bytes(0));
    try {
      out.push_back(object_model::read_parts(objects.bytes(1), views));
    } catch (const Error& e) {
      if (damaged) damaged->push_back(id + ": " + e.what());
    }
  }
  return out;
}

}  // namespace periplus::model
