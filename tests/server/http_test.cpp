// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include "http/message.hpp"
#include "http/site.hpp"
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::server::testing {
namespace {

struct HttpTest : ::testing::Test {
  HttpTest() {
    given.http.assets = {{"/", "text/html; charset=utf-8", "<p>front</p>"}, {"/app.js", "text/javascript", "run()"}};
    given.http.endpoints = {{"/healthz",
                             [] {
                               return Answer{503, "application/json", "{\"ok\": false}"};
                             }},
                            {"/broken", []() -> Answer { throw std::runtime_error{"no camera"}; }}};
    given.http.folders = {{"/results", folder.path()}};
    folder.write("inside.txt", "inside");
    folder.write("grids/000 1.npz", "0123456789");
    folder.write("video.mp4", std::string(300'000, 'v'));
    outside.write("secret.txt", "SECRET");
  }

  TemporaryFolder folder;
  TemporaryFolder outside;
  ServerOptions given{options()};
};

using Http = HttpTest;

TEST_F(Http, AssetsHaveTypeAndTag) {
  const Server server{given};
  const HttpAnswer page{get(server.port(), "/")};
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<p>front</p>");
  EXPECT_EQ(page.fields.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(page.fields.at("x-content-type-options"), "nosniff");
  EXPECT_THAT(page.fields.at("content-security-policy"), HasSubstr("default-src 'self'"));
  EXPECT_EQ(page.fields.at("referrer-policy"), "no-referrer");
  const std::string tag{page.fields.at("etag")};
  for (const std::string& known : {tag, "\"x\", W/" + tag, std::string{"*"}}) {
    const HttpAnswer again{get(server.port(), "/", "If-None-Match: " + known + "\r\n")};
    EXPECT_EQ(again.status, 304) << known;
    EXPECT_EQ(again.body, "");
  }
  EXPECT_EQ(get(server.port(), "/", "If-None-Match: \"x\"\r\n").status, 200);
  EXPECT_NE(get(server.port(), "/app.js").fields.at("etag"), tag);
  EXPECT_EQ(get(server.port(), "/app%2ejs?v=1").body, "run()");
}

TEST_F(Http, MethodsAndMissingPages) {
  const Server server{given};
  const HttpAnswer head{get(server.port(), "/", {}, "HEAD")};
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.fields.at("content-length"), "12");
  EXPECT_EQ(head.body, "");
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "BREW"}) {
    const HttpAnswer answer{get(server.port(), "/", {}, method)};
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.fields.at("allow"), "GET, HEAD");
  }
  EXPECT_EQ(get(server.port(), "/none").status, 404);
  EXPECT_EQ(get(server.port(), "/app.js/").status, 404);
  EXPECT_EQ(get(server.port(), "/", "Content-Length: 3\r\n\r\nabc").status, 413);
  EXPECT_EQ(get(server.port(), "/", "Content-Length: 99999999999\r\n").status, 413);
  EXPECT_EQ(get(server.port(), "/", "Transfer-Encoding: chunked\r\n\r\n0\r\n").status, 413);
  EXPECT_EQ(get(server.port(), "/", "X: " + std::string(20'000, 'x') + "\r\n").status, 431);
  EXPECT_EQ(get(server.port(), "/" + std::string(20'000, 'x')).status, 431);
}

TEST_F(Http, MalformedRequestsAreAnsweredAndClosed) {
  const Server server{given};
  for (const char* bytes :
       {"GARBAGE\r\n\r\n", "GET /\r\n\r\n", "GET / HTTP/9.9\r\nHost: localhost\r\n\r\n",
        "GET / HTTP/1.1\r\nHost localhost\r\n\r\n", "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\r\n\r\n",
        "GET  / HTTP/1.1\r\nHost: localhost\r\n\r\n"}) {
    const Wire wire{server.port()};
    wire.send(bytes);
    EXPECT_THAT(wire.receive_all(), HasSubstr("HTTP/1.1 400 ")) << bytes;
  }
  for (const char* host : {"", "Host: localhost\r\nHost: localhost\r\n"}) {
    EXPECT_EQ(ask(Wire{server.port()}, std::string{"GET / HTTP/1.1\r\n"} + host + "\r\n").status, 400) << host;
  }
  EXPECT_EQ(get(server.port(), "/").status, 200) << "and goes on";
}

TEST_F(Http, AConnectionIsKept) {
  const Server server{given};
  const Wire wire{server.port()};
  const std::string request{"GET /app.js HTTP/1.1\r\nHost: localhost\r\n\r\n"};
  for (int i{0}; i < 3; ++i) EXPECT_EQ(ask(wire, request).body, "run()");
  EXPECT_EQ(ask(wire, "GET /none HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 404);
  // both at once; the last has Connection: close
  wire.send(request + "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  const std::string both{wire.receive_all()};
  EXPECT_LT(both.find("run()"), both.find("<p>front</p>"));
  EXPECT_THAT(both, HasSubstr("Connection: close"));
  const Wire old{server.port()};
  old.send("GET /app.js HTTP/1.0\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(old.receive_all(), HasSubstr("run()"));
}

TEST_F(Http, Endpoints) {
  const Server server{given};
  const HttpAnswer health{get(server.port(), "/healthz")};
  EXPECT_EQ(health.status, 503);
  EXPECT_EQ(health.fields.at("content-type"), "application/json");
  EXPECT_EQ(health.fields.at("cache-control"), "no-store");
  EXPECT_EQ(health.body, "{\"ok\": false}");
  const HttpAnswer broken{get(server.port(), "/broken")};
  EXPECT_EQ(broken.status, 500);
  EXPECT_THAT(broken.body, HasSubstr("no camera"));
}

TEST_F(Http, FilesOfAFolder) {
  const Server server{given};
  const HttpAnswer file{get(server.port(), "/results/grids/000%201.npz")};
  EXPECT_EQ(file.status, 200);
  EXPECT_EQ(file.body, "0123456789");
  EXPECT_EQ(file.fields.at("content-type"), "application/octet-stream");
  EXPECT_EQ(file.fields.at("x-content-type-options"), "nosniff");
  EXPECT_THAT(file.fields.at("content-security-policy"), HasSubstr("default-src 'self'"));
  const std::string tag{file.fields.at("etag")};
  EXPECT_EQ(get(server.port(), "/results/grids/000%201.npz", "If-None-Match: " + tag + "\r\n").status, 304);
  folder.write("grids/000 1.npz", "another");
  EXPECT_EQ(get(server.port(), "/results/grids/000%201.npz", "If-None-Match: " + tag + "\r\n").body, "another");
  EXPECT_EQ(get(server.port(), "/results/video.mp4").body, std::string(300'000, 'v'));
  EXPECT_EQ(get(server.port(), "/results/video.mp4", {}, "HEAD").fields.at("content-length"), "300000");
}

TEST_F(Http, RangesOfAFile) {
  const Server server{given};
  const auto part{[&](const std::string& range, const std::string& more = {}) {
    return get(server.port(), "/results/grids/000%201.npz", "Range: " + range + "\r\n" + more);
  }};
  const HttpAnswer middle{part("bytes=2-4")};
  EXPECT_EQ(middle.status, 206);
  EXPECT_EQ(middle.body, "234");
  EXPECT_EQ(middle.fields.at("content-range"), "bytes 2-4/10");
  EXPECT_EQ(part("bytes=7-").body, "789");
  EXPECT_EQ(part("bytes=-3").body, "789");
  EXPECT_EQ(part("bytes=8-99").body, "89");
  EXPECT_EQ(part("bytes=-99").body, "0123456789");
  for (const char* unsatisfiable : {"bytes=10-", "bytes=99-100", "bytes=-0"}) {
    EXPECT_EQ(part(unsatisfiable).status, 416) << unsatisfiable;
    EXPECT_EQ(part(unsatisfiable).fields.at("content-range"), "bytes */10");
  }
  for (const char* ignored : {"bytes=4-2", "bytes=a-b", "lines=1-2", "bytes=1-2,4-5", "bytes=", "bytes=-", "bytes=--1",
                              "bytes=1-18446744073709551616"}) {
    EXPECT_EQ(part(ignored).status, 200) << ignored;
  }
  const std::string tag{part("bytes=0-0").fields.at("etag")};
  EXPECT_EQ(part("bytes=0-0", "If-Range: " + tag + "\r\n").status, 206);
  EXPECT_EQ(part("bytes=0-0", "If-Range: \"old\"\r\n").status, 200);
}

/// Known path traversals to a file; and paths that are no files of the folder.
std::vector<std::string> escapes(const std::filesystem::path& file) {
  const std::string name{file.parent_path().filename().string()};
  const std::string whole{file.string()};
  return {"../" + name + "/secret.txt",
          "%2e%2e/" + name + "/secret.txt",
          "%2E%2E%2F" + name + "%2Fsecret.txt",
          "grids/../../" + name + "/secret.txt",
          ".%2e/" + name + "/secret.txt",
          "..%2f" + name + "/secret.txt",
          "..%5c" + name + "%5csecret.txt",
          "..\\" + name + "\\secret.txt",
          "....//" + name + "/secret.txt",
          "%252e%252e/" + name + "/secret.txt",
          "%c0%ae%c0%ae/" + name + "/secret.txt",
          "..;/" + name + "/secret.txt",
          "/" + whole,
          whole,
          "link.txt",
          "linked/secret.txt",
          "root" + whole,
          "inside.txt%00.png",
          "%00",
          ".",
          "..",
          "./inside.txt",
          "grids/./000%201.npz",
          "inside.txt/",
          "inside.txt/x",
          "grids",
          "grids/",
          "",
          "fifo",
          "inside.txt%",
          "inside.txt%2",
          "%zz",
          std::string(4000, 'a')};
}

TEST_F(Http, NoPathLeavesTheFolder) {
  namespace fs = std::filesystem;
  fs::create_symlink(outside / "secret.txt", folder / "link.txt");
  fs::create_symlink(outside.path(), folder / "linked");
  fs::create_symlink("/", folder / "root");
  ::mkfifo((folder / "fifo").c_str(), 0600);
  const Server server{given};
  for (const std::string& path : escapes(outside / "secret.txt")) {
    const HttpAnswer answer{get(server.port(), "/results/" + path)};
    EXPECT_TRUE(answer.status == 400 || answer.status == 404) << path << ": " << answer.status;
    EXPECT_THAT(answer.body, Not(HasSubstr("SECRET"))) << path;
  }
  EXPECT_EQ(get(server.port(), "/results").status, 404);
  EXPECT_EQ(get(server.port(), "/resultsinside.txt").status, 404);
  EXPECT_EQ(get(server.port(), "results/inside.txt").status, 400);
  EXPECT_EQ(get(server.port(), "http://localhost/results/inside.txt").status, 400);
  EXPECT_EQ(get(server.port(), "/results/inside.txt").body, "inside");
}

TEST_F(Http, AFileThatShrinksEndsTheConnection) {
  folder.write("large", std::string(40'000'000, 'l'));
  const Server server{given};
  const Wire wire{server.port(), 65'536};
  wire.send("GET /results/large HTTP/1.1\r\nHost: localhost\r\n\r\n");
  std::string received{wire.receive()};
  std::filesystem::resize_file(folder / "large", 10);
  received += wire.receive_all();
  EXPECT_LT(received.size(), 40'000'000U);
}

TEST_F(Http, OptionsThatCannotWork) {
  const auto fails{[&](const std::string& path) {
    ServerOptions bad{options()};
    bad.http.assets = {{path, "text/plain", ""}};
    EXPECT_THROW(Server{bad}, ConfigError) << path;
  }};
  for (const char* path : {"", "page", "/a/../b", "/a?b", "/a%20b", "/a#b", "//"}) fails(path);
  ServerOptions twice{given};
  twice.http.endpoints.push_back({"/", [] { return Answer{}; }});
  EXPECT_THROW(Server{twice}, ConfigError);
  ServerOptions missing{options()};
  missing.http.folders = {{"/results", folder / "none"}};
  EXPECT_THROW(Server{missing}, InputError);
}

}  // namespace
}  // namespace stereogrid::server::testing
