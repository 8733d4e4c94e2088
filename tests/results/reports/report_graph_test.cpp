// A map of places on a page: what is drawn, and that what was seen all around lies over the place as it was known.

#include "results/reports/report_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "algorithms/core/clock.h"
#include "results/scoring/place_graph_score.h"

namespace gaitcam {
namespace {

using testing::HasSubstr;
using testing::Not;
constexpr int kWidth = 720, kHeight = 80;

/// One bright bar on dark ground, its middle in column `x`.
cv::Mat Bar(int x) {
  cv::Mat panorama(kHeight, kWidth, CV_8UC1, cv::Scalar(30));
  cv::rectangle(panorama, {x - 20, 0, 41, kHeight}, cv::Scalar(220), cv::FILLED);
  return panorama;
}

/// Four places along a straight way of 4 m, back to the second one at its end. The bar lies 90 degrees to the right of
/// the known panorama's middle; the robot has turned to the right by 60 degrees when it sees it again.
PlaceGraph Graph(int loops = 1) {
  PlaceGraph graph;
  for (int k = 0; k < 4; ++k)
    graph.nodes.push_back({kClockStart_ns + k * 10'000'000'000LL, 169, Bar(kWidth / 2 + 180)});
  for (int k = 0; k < 3; ++k) graph.links.push_back({k, k + 1, false, kClockStart_ns + (k + 1) * 10'000'000'000LL});
  for (int k = 0; k < loops; ++k) {
    const int64_t stamp = kClockStart_ns + 50'000'000'000LL + k;
    graph.links.push_back({3, 1, true, stamp});
    graph.tests.push_back(
        {stamp, {1, 0, 4, 0, 0}, {0.2, 0, 0.8, 0, 0}, 1, -std::numbers::pi / 3, Bar(kWidth / 2 + 60)});
  }
  return graph;
}

Trajectory OutAndBack() {
  Trajectory truth;
  for (int k = 0; k <= 520; ++k) {
    const double s = 0.1 * k, x = 0.1 * std::min(s, 70 - s);  // turns at 35 s
    truth.push_back({kClockStart_ns + k * 100'000'000LL, Pose{Eigen::Quaterniond::Identity(), {x, 0.001 * s, 0.3}}});
  }
  return truth;
}

std::string Section(const PlaceGraph& graph) {
  return internal::PlaceSection(ComparePlaceGraph(graph, OutAndBack()), graph);
}

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::vector<uchar> FromBase64(const std::string& text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<uchar> bytes;
  uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | uint32_t(letters.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(uchar(bits >> count));
  }
  return bytes;
}

/// The pictures of a page, in their order.
std::vector<cv::Mat> Pictures(const std::string& html) {
  const std::string head = "base64,";
  std::vector<cv::Mat> pictures;
  for (size_t at = html.find(head); at != std::string::npos; at = html.find(head, at + 1)) {
    const size_t begin = at + head.size();
    pictures.push_back(
        cv::imdecode(FromBase64(html.substr(begin, html.find('"', begin) - begin)), cv::IMREAD_GRAYSCALE));
  }
  return pictures;
}

/// Middle of what is bright, as a share of the width.
double BrightAt(const cv::Mat& picture) {
  const cv::Moments moments = cv::moments(picture > 120, true);
  return moments.m10 / moments.m00 / picture.cols;
}

TEST(ReportGraph, EveryPlaceLinkAndLoopIsDrawn) {
  const std::string html = Section(Graph());
  EXPECT_EQ(Count(html, "<circle class=\"node\""), 4u);
  EXPECT_EQ(Count(html, "<line class=\"link\""), 3u);
  EXPECT_EQ(Count(html, "<line class=\"wrong\""), 1u);  // the robot is at 2 m, the place at 1 m
  EXPECT_THAT(html, HasSubstr("False: place 1"));
  EXPECT_THAT(html, HasSubstr("at 50.0 s, "));  // since the walk began, whatever the clock shows
}

TEST(ReportGraph, WhatWasSeenAllAroundLiesOverThePlaceAsItWasKnown) {
  const std::vector<cv::Mat> pictures = Pictures(Section(Graph()));
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_EQ(pictures[0].size(), pictures[1].size());
  // The bar is 75 % of the way to the right in the known panorama; a pixel of 720.
  EXPECT_NEAR(BrightAt(pictures[1]), 0.75, 0.002);
  EXPECT_NEAR(BrightAt(pictures[0]), BrightAt(pictures[1]), 0.002);
}

TEST(ReportGraph, AViewStandsBesideThePanoramaThatItWasFoundIn) {
  PlaceGraph graph = Graph();
  graph.tests[0].view = cv::Mat(kHeight, 120, CV_8UC1, cv::Scalar(100));
  const std::string html = Section(graph);
  EXPECT_THAT(html, HasSubstr("the view&rsquo;s window"));
  const std::vector<cv::Mat> pictures = Pictures(html);
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_LT(pictures[0].cols, pictures[1].cols);
}

TEST(ReportGraph, OfPlacesSeenInOneViewBothViewsAreShown) {
  PlaceGraph graph = Graph();
  for (PlaceNode& node : graph.nodes) {
    node.panorama = cv::Mat();
    node.view = cv::Mat(kHeight, 120, CV_8UC1, cv::Scalar(200));
  }
  graph.tests[0].view = cv::Mat(kHeight, 120, CV_8UC1, cv::Scalar(100));
  graph.tests[0].posterior.clear();
  const std::string html = Section(graph);
  EXPECT_THAT(html, HasSubstr("the place as it was seen"));
  EXPECT_THAT(html, Not(HasSubstr("posterior")));
  const std::vector<cv::Mat> pictures = Pictures(html);
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_LT(cv::mean(pictures[0])[0], cv::mean(pictures[1])[0]) << "the view is left of the place";
  const PlaceGraphComparison comparison = ComparePlaceGraph(graph, OutAndBack());
  EXPECT_THAT(internal::PlaceCards(comparison, graph), Not(HasSubstr("all around")));
  EXPECT_THAT(internal::PlaceCards(comparison, Graph()), HasSubstr("all around"));
}

TEST(ReportGraph, PlacesThatStandTooCloseHaveNoNumbersOfTheirOwn) {
  PlaceGraph graph = Graph();
  EXPECT_EQ(Count(Section(graph), "<text"), 4u);
  for (int k = 1; k <= 20; ++k) {  // 2 mm apart
    graph.nodes.push_back({graph.nodes.back().stamp_ns + 20'000'000, 169, {}});
  }
  EXPECT_EQ(Count(Section(graph), "<text"), 4u);
  EXPECT_EQ(Count(Section(graph), "<circle class=\"node\""), 24u);
}

TEST(ReportGraph, OfManyLoopsTheFirstAreShownAndThatIsSaid) {
  EXPECT_THAT(Section(Graph(3)), Not(HasSubstr("the first")));
  const std::string html = Section(Graph(11));
  EXPECT_THAT(html, HasSubstr("What closed the loops (the first 8 of 11)"));
  EXPECT_EQ(Count(html, "<figure>"), 8u);
}

TEST(ReportGraph, AMapWithoutLoopsHasNoSectionForThem) {
  EXPECT_THAT(Section(Graph(0)), Not(HasSubstr("What closed the loops")));
}

}  // namespace
}  // namespace gaitcam
