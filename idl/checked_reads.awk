# awk -f checked_reads.awk A.idl … A.cxx …: writes each A.cxx of fastddsgen, which forgets the bounds of sequences and cuts
# strings that are too long, to A.cxx.checked, whose members are read through the checks of bounded_read.h.

function fail(text) {
  print FILENAME ": " text > "/dev/stderr"
  failed = 1
  exit 1
}

function scope(  i, text) {
  for (i = 1; i <= depth; ++i) text = text name[i] "::"
  return text
}

# `bounds["periplus::msg::Blob"]` of typedefs, `bounds["periplus::msg::PlanViewRequest::forbidden"]` of members.
function declare(statement,  words, n, tail, type) {
  n = split(statement, words, " ")
  if (statement ~ /sequence *</) {
    if (gsub(/sequence *</, "&", statement) > 1) fail("a sequence of sequences needs a name for the inner one: " statement)
    if (match(statement, /, *[0-9]+ *> *[A-Za-z_0-9]+$/)) {
      tail = substr(statement, RSTART + 1)
      bounds[scope() words[n]] = tail + 0
      if (statement ~ /^typedef /) is_typedef[scope() words[n]] = 1
    } else if (statement ~ /, *[^<>]*> *[A-Za-z_0-9, ]+$/) {
      fail("the bound is no number, or there are several names: " statement)
    }
  } else if (depth > 1 && n > 1) {
    type = words[n - 1]
    for (i = depth - 1; i >= 0; --i) {
      if ((prefix(i) type) in is_typedef) {
        bounds[scope() words[n]] = bounds[prefix(i) type]
        break
      }
    }
  }
}

function prefix(levels,  i, text) {
  for (i = 1; i <= levels; ++i) text = text name[i] "::"
  return text
}

FILENAME ~ /\.idl$/ {
  if (FNR == 1) {
    depth = 0
    text = ""
  }
  sub(/\/\/.*/, "")
  if ($0 ~ /^#/) next
  text = text $0 " "
  while (match(text, /[{};]/)) {
    statement = substr(text, 1, RSTART - 1)
    mark = substr(text, RSTART, 1)
    text = substr(text, RSTART + 1)
    gsub(/^[ \t]+|[ \t]+$/, "", statement)
    if (mark == "{") {
      count = split(statement, parts, " ")
      name[++depth] = parts[count]
    } else if (mark == "}") {
      --depth
    } else if (statement != "") {
      declare(statement)
    }
  }
  next
}

FNR == 1 { out = FILENAME ".checked" }

/\/\/ m_[A-Za-z0-9_]+ com\.eprosima/ { sub(/ com\.eprosima.*/, "") }  # a Java identity: another one each time

/::deserialize\($/ {
  type = $2
  sub(/deserialize\($/, "", type)
}

match($0, /dcdr >> m_[A-Za-z0-9_]+;/) {
  member = substr($0, RSTART + 8, RLENGTH - 9)
  key = type substr(member, 3)
  bound = ""
  if (key in bounds) {
    bound = ", " bounds[key]
    used[key] = 1
  }
  $0 = substr($0, 1, RSTART - 1) "periplus::idl::read_checked(dcdr, " member bound ");" substr($0, RSTART + RLENGTH)
}

match($0, /m_[A-Za-z0-9_]+ = aux\.c_str\(\);/) {
  member = substr($0, RSTART, RLENGTH - 15)
  $0 = substr($0, 1, RSTART - 1) "periplus::idl::assign_bounded(" member ", aux);" substr($0, RSTART + RLENGTH)
}

{ print > out }

/^#include <fastcdr\/Cdr.h>/ { print "#include \"common/dds/bounded_read.h\"" > out }

END {
  if (failed) exit 1
  for (key in bounds) {
    if (!(key in used) && !(key in is_typedef)) fail("the generated code does not read " key " as expected")
  }
}
