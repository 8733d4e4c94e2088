#include "algorithms/io/place_graph_file.h"

#include <tinyxml2.h>

#include <charconv>
#include <string>

#include "algorithms/core/errors.h"
#include "algorithms/io/text_table.h"
#include "algorithms/io/whole_file.h"

namespace gaitcam {
namespace {

using tinyxml2::XMLElement;

struct Key {
  const char* id;
  const char* domain;
  const char* type;
};

constexpr Key kKeys[] = {{"stamp_ns", "all", "long"},
                         {"bytes", "node", "long"},
                         {"x_m", "node", "double"},
                         {"y_m", "node", "double"},
                         {"loop", "edge", "boolean"}};

void AddData(XMLElement& parent, const char* key, const std::string& value) {
  XMLElement* data = parent.InsertNewChildElement("data");
  data->SetAttribute("key", key);
  data->SetText(value.c_str());
}

[[noreturn]] void Fail(const std::filesystem::path& file, int line, const std::string& message) {
  throw BadInput(file.string() + ":" + std::to_string(line) + ": " + message);
}

/// Two spaces for each level.
class GraphMlPrinter : public tinyxml2::XMLPrinter {
 protected:
  void PrintSpace(int depth) override {
    for (int i = 0; i < depth; ++i) Write("  ");
  }
};

/// Reads elements' data with errors that point at them.
class Reader {
 public:
  explicit Reader(std::filesystem::path file) : file_(std::move(file)) {}

  const char* Find(const XMLElement& element, const char* key) const {
    for (const XMLElement* data = element.FirstChildElement("data"); data; data = data->NextSiblingElement("data")) {
      const char* name = data->Attribute("key");
      if (name && std::string(name) == key && data->GetText()) return data->GetText();
    }
    return nullptr;
  }
  std::string Text(const XMLElement& element, const char* key) const {
    if (const char* text = Find(element, key)) return text;
    Fail(file_, element.GetLineNum(), std::string(element.Value()) + " has no data for the key " + key);
  }
  template <class Number>
  Number Value(const XMLElement& element, const char* key) const {
    const std::string text = Text(element, key);
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
      Fail(file_, element.GetLineNum(), std::string(key) + ": \"" + text + "\" is not a number");
    }
    return value;
  }
  int Node(const XMLElement& edge, const char* attribute, size_t nodes) const {
    const char* text = edge.Attribute(attribute);
    int node = -1;
    const std::string id = text ? text : "";
    if (id.size() > 1 && id[0] == 'n') std::from_chars(id.data() + 1, id.data() + id.size(), node);
    if (node >= 0 && size_t(node) < nodes) return node;
    Fail(file_, edge.GetLineNum(), std::string("edge: ") + attribute + " = \"" + id + "\" is no node of this graph");
  }

 private:
  std::filesystem::path file_;
};

}  // namespace

void WritePlaceGraph(const std::filesystem::path& file, const PlaceGraph& graph,
                     const std::vector<Eigen::Vector2d>& positions_m) {
  GAITCAM_ASSERT(positions_m.empty() || positions_m.size() == graph.nodes.size());
  tinyxml2::XMLDocument document;
  document.InsertEndChild(document.NewDeclaration());
  XMLElement* root = document.NewElement("graphml");
  document.InsertEndChild(root);
  root->SetAttribute("xmlns", "http://graphml.graphdrawing.org/xmlns");
  for (const Key& key : kKeys) {
    XMLElement* element = root->InsertNewChildElement("key");
    element->SetAttribute("id", key.id);
    element->SetAttribute("for", key.domain);
    element->SetAttribute("attr.name", key.id);
    element->SetAttribute("attr.type", key.type);
  }
  XMLElement* places = root->InsertNewChildElement("graph");
  places->SetAttribute("id", "places");
  places->SetAttribute("edgedefault", "undirected");
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    XMLElement* node = places->InsertNewChildElement("node");
    node->SetAttribute("id", ("n" + std::to_string(i)).c_str());
    AddData(*node, "stamp_ns", std::to_string(graph.nodes[i].stamp_ns));
    AddData(*node, "bytes", std::to_string(graph.nodes[i].bytes));
    if (positions_m.empty()) continue;
    AddData(*node, "x_m", ExactText(positions_m[i].x()));
    AddData(*node, "y_m", ExactText(positions_m[i].y()));
  }
  for (const PlaceLink& link : graph.links) {
    XMLElement* edge = places->InsertNewChildElement("edge");
    edge->SetAttribute("source", ("n" + std::to_string(link.from)).c_str());
    edge->SetAttribute("target", ("n" + std::to_string(link.to)).c_str());
    AddData(*edge, "stamp_ns", std::to_string(link.stamp_ns));
    AddData(*edge, "loop", link.loop ? "true" : "false");
  }
  GraphMlPrinter printer;
  document.Print(&printer);
  WriteWholeFile(file, printer.CStr());
}

PlaceGraphFile ReadPlaceGraph(const std::filesystem::path& file) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(file.string().c_str()) != tinyxml2::XML_SUCCESS) {
    Fail(file, document.ErrorLineNum(), document.ErrorName());
  }
  const XMLElement* root = document.FirstChildElement("graphml");
  const XMLElement* places = root ? root->FirstChildElement("graph") : nullptr;
  if (!places) Fail(file, 1, "there is no <graphml> with a <graph> in it");
  const Reader reader(file);
  PlaceGraphFile result;
  for (const XMLElement* node = places->FirstChildElement("node"); node; node = node->NextSiblingElement("node")) {
    PlaceNode place;
    place.stamp_ns = reader.Value<int64_t>(*node, "stamp_ns");
    place.bytes = reader.Value<size_t>(*node, "bytes");
    result.graph.nodes.push_back(place);
    if (reader.Find(*node, "x_m"))
      result.positions_m.emplace_back(reader.Value<double>(*node, "x_m"), reader.Value<double>(*node, "y_m"));
  }
  const size_t nodes = result.graph.nodes.size();
  if (!result.positions_m.empty() && result.positions_m.size() != nodes)
    Fail(file, places->GetLineNum(), "some nodes have positions, some have none");
  for (const XMLElement* edge = places->FirstChildElement("edge"); edge; edge = edge->NextSiblingElement("edge")) {
    PlaceLink link;
    link.from = reader.Node(*edge, "source", nodes);
    link.to = reader.Node(*edge, "target", nodes);
    link.stamp_ns = reader.Value<int64_t>(*edge, "stamp_ns");
    link.loop = reader.Text(*edge, "loop") == "true";
    result.graph.links.push_back(link);
  }
  return result;
}

}  // namespace gaitcam
