#include "algorithms/io/place_graph_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include "algorithms/core/errors.h"
#include "tests/algorithms/io/file_test.h"

namespace gaitcam {
namespace {

class GraphMl : public FileTest {};

PlaceGraph SomeGraph() {
  PlaceGraph graph;
  for (const int64_t stamp_ns : {5LL, 7000000000123LL, 9000000000000LL}) graph.nodes.push_back({stamp_ns, 169, {}});
  graph.links = {{0, 1, false, 17}, {1, 2, false, 18}, {2, 0, true, 19}};
  return graph;
}

TEST_F(GraphMl, ComesBackAsItWasWritten) {
  const std::vector<Eigen::Vector2d> positions = {{0.1, -2.0 / 3}, {1e-9, 4}, {-3, 0}};
  WritePlaceGraph(folder_ / "map.graphml", SomeGraph(), positions);
  const PlaceGraphFile read = ReadPlaceGraph(folder_ / "map.graphml");
  ASSERT_EQ(read.graph.nodes.size(), 3u);
  ASSERT_EQ(read.graph.links.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.graph.nodes[i].stamp_ns, SomeGraph().nodes[i].stamp_ns);
    EXPECT_EQ(read.graph.nodes[i].bytes, 169u);
    EXPECT_EQ(read.positions_m[i], positions[i]);
    EXPECT_EQ(read.graph.links[i].from, SomeGraph().links[i].from);
    EXPECT_EQ(read.graph.links[i].to, SomeGraph().links[i].to);
    EXPECT_EQ(read.graph.links[i].loop, SomeGraph().links[i].loop);
    EXPECT_EQ(read.graph.links[i].stamp_ns, SomeGraph().links[i].stamp_ns);
  }
}

TEST_F(GraphMl, NeedsNoPositions) {
  WritePlaceGraph(folder_ / "map.graphml", SomeGraph());
  EXPECT_TRUE(ReadPlaceGraph(folder_ / "map.graphml").positions_m.empty());
}

TEST_F(GraphMl, DeclaresEveryKeyThatItUses) {
  WritePlaceGraph(folder_ / "map.graphml", SomeGraph(), {{0, 0}, {1, 0}, {2, 0}});
  tinyxml2::XMLDocument document;
  ASSERT_EQ(document.LoadFile((folder_ / "map.graphml").string().c_str()), tinyxml2::XML_SUCCESS);
  const tinyxml2::XMLElement* root = document.RootElement();
  EXPECT_STREQ(root->Attribute("xmlns"), "http://graphml.graphdrawing.org/xmlns");
  std::vector<std::string> keys;
  for (const tinyxml2::XMLElement* key = root->FirstChildElement("key"); key; key = key->NextSiblingElement("key"))
    keys.push_back(key->Attribute("id"));
  EXPECT_THAT(keys, testing::UnorderedElementsAre("stamp_ns", "bytes", "x_m", "y_m", "loop"));
}

TEST_F(GraphMl, SaysWhereAFileIsWrong) {
  const auto error = [&](const std::string& text) -> std::string {
    try {
      ReadPlaceGraph(Write("bad.graphml", text));
    } catch (const BadInput& bad) {
      return bad.what();
    }
    return "no error";
  };
  EXPECT_THAT(error("<graphml>"), testing::HasSubstr("bad.graphml:"));
  EXPECT_THAT(error("<other/>"), testing::HasSubstr("no <graphml>"));
  EXPECT_THAT(error("<graphml><graph>\n<node id=\"n0\"/></graph></graphml>"),
              testing::HasSubstr(":2: node has no data"));
  EXPECT_THAT(error("<graphml><graph>\n<edge source=\"n0\" target=\"n1\"/></graph></graphml>"),
              testing::HasSubstr("source = \"n0\" is no node"));
  EXPECT_THROW(ReadPlaceGraph(folder_ / "none.graphml"), BadInput);
}

}  // namespace
}  // namespace gaitcam
