// SPDX-License-Identifier: Apache-2.0
// Who may ask: Host, Origin, token.
#include "http/site.hpp"

#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::server::testing {
namespace {

using ::testing::MatchesRegex;

ServerOptions with_page() {
  ServerOptions given{options()};
  given.http.assets = {{"/", "text/html", "front"}};
  return given;
}

TEST(Access, OnLoopbackOnlyItsOwnNames) {
  const Server server{with_page()};
  const std::string port{std::to_string(server.port())};
  for (const std::string& host :
       {std::string{"localhost"}, "localhost:" + port, std::string{"LOCALHOST"}, "127.0.0.1:" + port,
        std::string{"[::1]:9"}, std::string{"[::1]"}, std::string{"localhost:12345"}}) {
    EXPECT_EQ(get(server.port(), "/", "Host: " + host + "\r\n").status, 200) << host;
    EXPECT_EQ(Client(server.port(), {.host = host}).accepted().status, 101) << host;
  }
  for (const char* host : {"evil.example", "evil.example:8765", "localhost.evil.example", "127.0.0.1.evil.example",
                           "127.0.0.2", "[::2]", "0.0.0.0", "localhost.", "localhost:80:80", "a b"}) {
    const HttpAnswer page{get(server.port(), "/", std::string{"Host: "} + host + "\r\n")};
    EXPECT_EQ(page.status, 403) << host;
    EXPECT_THAT(page.body, HasSubstr("open it as localhost"));
    EXPECT_EQ(refusal(server.port(), {.host = host}).status, 403) << host;
  }
  EXPECT_EQ(server.counts().refused, 20U);
}

TEST(Access, AnotherLoopbackAddressIsItsOwnName) {
  ServerOptions given{with_page()};
  given.address = "127.0.0.2";
  const Server server{given};
  EXPECT_EQ(server.token(), "");
  EXPECT_EQ(ask(Wire{server.port(), 0, "127.0.0.2"}, "GET / HTTP/1.1\r\nHost: 127.0.0.2:1\r\n\r\n").status, 200);
}

TEST(Access, PagesOfOtherSitesMayNotConnect) {
  ServerOptions given{with_page()};
  given.allowed_origins = {"https://app.foxglove.dev", "null"};
  const Server server{given};
  const std::string own{"127.0.0.1:" + std::to_string(server.port())};
  for (const std::string& origin : {"http://" + own, "https://" + own, std::string{"HTTP://"} + own,
                                    std::string{"https://app.foxglove.dev"}, std::string{"null"}}) {
    EXPECT_EQ(Client(server.port(), {.fields = "Origin: " + origin + "\r\n"}).accepted().status, 101) << origin;
  }
  for (const std::string& origin :
       {std::string{"http://evil.example"}, std::string{"http://localhost"}, std::string{"http://127.0.0.1"},
        std::string{"http://127.0.0.1:1"}, "ftp://" + own, own, "http://" + own + "/", std::string{"file://"},
        std::string{"http://app.foxglove.dev"}, std::string{"https://app.foxglove.dev.evil.example"},
        std::string{"https://app.foxglove.dev:444"}}) {
    const HttpAnswer answer{refusal(server.port(), {.fields = "Origin: " + origin + "\r\n"})};
    EXPECT_EQ(answer.status, 403) << origin;
    EXPECT_THAT(answer.body, HasSubstr("allowed origins"));
  }
  const std::string two{"Origin: http://evil.example\r\nOrigin: https://app.foxglove.dev\r\n"};
  EXPECT_EQ(refusal(server.port(), {.fields = two}).status, 403);
}

struct TokenTest : ::testing::Test {
  TokenTest() { given.token = token; }
  const std::string token{"0123456789abcdefABCDEF-_"};
  ServerOptions given{with_page()};
};

TEST_F(TokenTest, IsNeededForEverything) {
  given.http.endpoints = {{"/healthz", [] { return Answer{}; }}};
  const Server server{given};
  EXPECT_EQ(server.token(), token);
  EXPECT_THAT(server.url(), HasSubstr("/?token=" + token));
  const std::string port{std::to_string(server.port())};
  const std::string wrong{"1" + token.substr(1)};
  for (const std::string& fields :
       {std::string{}, "Authorization: Bearer " + wrong + "\r\n", "Authorization: Basic " + token + "\r\n",
        "Authorization: " + token + "\r\n", std::string{"Authorization: Bearer \r\n"}, "Cookie: " + token + "\r\n",
        "Cookie: stereogrid_token_" + port + "=" + wrong + "\r\n",
        "Cookie: xstereogrid_token_" + port + "=" + token + "\r\n", "Cookie: stereogrid_token_1=" + token + "\r\n",
        "Sec-WebSocket-Protocol: " + token + "\r\n"}) {
    for (const std::string& target : {std::string{"/"}, std::string{"/healthz"}, std::string{"/none"},
                                      "/?token=" + wrong, std::string{"/?token="}, "/?Token=" + token}) {
      const HttpAnswer answer{get(server.port(), target, fields)};
      EXPECT_EQ(answer.status, 401) << fields << target;
      EXPECT_EQ(answer.fields.at("www-authenticate"), "Bearer");
      EXPECT_EQ(answer.fields.count("set-cookie"), 0U);
      EXPECT_EQ(refusal(server.port(), {.fields = fields, .target = target}).status, 401) << fields << target;
    }
  }
}

TEST_F(TokenTest, IsTakenFromQueryHeaderAndCookie) {
  const Server server{given};
  const std::string port{std::to_string(server.port())};
  const HttpAnswer page{get(server.port(), "/?a=b&token=" + token)};
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.fields.at("set-cookie"),
            "stereogrid_token_" + port + "=" + token + "; Path=/; HttpOnly; SameSite=Strict");
  const std::string cookie{"Cookie: other=1; stereogrid_token_" + port + "=" + token + "; last=2\r\n"};
  for (const std::string& fields :
       {cookie, "Authorization: Bearer " + token + "\r\n", "authorization: bearer  " + token + "\r\n"}) {
    const HttpAnswer answer{get(server.port(), "/", fields)};
    EXPECT_EQ(answer.status, 200) << fields;
    EXPECT_EQ(answer.fields.count("set-cookie"), 0U);
    EXPECT_EQ(Client(server.port(), {.fields = fields}).accepted().status, 101) << fields;
  }
  EXPECT_EQ(Client(server.port(), {.target = "/?token=" + token}).accepted().status, 101);
  const std::string foreign{"Origin: http://evil.example\r\n"};
  EXPECT_EQ(refusal(server.port(), {.fields = cookie + foreign}).status, 403) << "a cookie does not make up for it";
}

TEST(Access, BeyondLoopbackATokenIsMadeUp) {
  ServerOptions given{with_page()};
  given.address = "0.0.0.0";
  const Server server{given};
  const Server other{given};
  EXPECT_THAT(server.token(), MatchesRegex("[0-9a-f]{40}"));
  EXPECT_NE(server.token(), other.token());
  EXPECT_EQ(get(server.port(), "/").status, 401);
  EXPECT_EQ(get(server.port(), "/?token=" + server.token(), "Host: robot.example:8765\r\n").status, 200);
}

TEST(Access, TokensThatAreNone) {
  for (const char* token :
       {"short", "0123456789abcdef01234", "0123456789 abcdef0123456789", "0123456789;abcdef0123456789"}) {
    ServerOptions given{options()};
    given.token = token;
    EXPECT_THROW(Server{given}, ConfigError) << token;
  }
}

TEST(Access, ComparesEveryCharacter) {
  const std::string secret{"abcdefgh"};
  EXPECT_TRUE(equal_in_constant_time(secret, "abcdefgh"));
  for (std::size_t i{0}; i < secret.size(); ++i) {
    std::string other{secret};
    other[i] = static_cast<char>(other[i] ^ 0x80);
    EXPECT_FALSE(equal_in_constant_time(secret, other)) << i;
  }
  EXPECT_FALSE(equal_in_constant_time(secret, "abcdefg"));
  EXPECT_FALSE(equal_in_constant_time(secret, ""));
}

}  // namespace
}  // namespace stereogrid::server::testing
