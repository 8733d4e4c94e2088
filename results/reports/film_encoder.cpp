#include "results/reports/film_encoder.h"

#include <algorithm>

#include "algorithms/core/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

namespace gaitcam {
namespace {

constexpr const char* kPreset = "veryfast";  ///< A quarter of the default's time, a third more bytes.
constexpr const char* kQuality = "23";       ///< x264's constant rate factor: 23 is usual, less is better.
constexpr double kKeyEvery_s = 2;            ///< A player that jumps decodes from such a picture on.

struct Free {
  void operator()(AVFormatContext* format) const {
    avio_closep(&format->pb);
    avformat_free_context(format);
  }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* scale) const { sws_freeContext(scale); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

}  // namespace

struct FilmEncoder::Parts {
  std::string name;
  Owned<AVFormatContext> format;
  Owned<AVCodecContext> codec;
  AVStream* stream = nullptr;  ///< The format's.
  Owned<AVFrame> picture{av_frame_alloc()};
  Owned<AVPacket> packet{av_packet_alloc()};
  Owned<SwsContext> to_yuv;

  /// @param result of one of FFmpeg's functions, negative where it failed.
  void Check(int result, const std::string& what) const {
    if (result >= 0) return;
    char reason[AV_ERROR_MAX_STRING_SIZE] = "";
    av_strerror(result, reason, sizeof reason);
    throw MissingResource(name + ": " + what + ": " + reason);
  }

  void OpenCodec(cv::Size size, double rate_hz) {
    const AVCodec* x264 = avcodec_find_encoder_by_name("libx264");
    if (x264 == nullptr) {
      throw MissingResource(name + ": cannot write an H.264 film; FFmpeg needs libx264 (Debian: libavcodec59)");
    }
    codec.reset(avcodec_alloc_context3(x264));
    codec->width = size.width;
    codec->height = size.height;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->framerate = av_d2q(rate_hz, 1000000);
    codec->time_base = av_inv_q(codec->framerate);
    codec->gop_size = std::max(1, int(kKeyEvery_s * rate_hz + 0.5));
    codec->thread_count = 1;
    codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
    av_opt_set(codec->priv_data, "preset", kPreset, 0);
    av_opt_set(codec->priv_data, "tune", "zerolatency", 0);  // keeps two pictures and not twenty
    av_opt_set(codec->priv_data, "crf", kQuality, 0);
    Check(avcodec_open2(codec.get(), x264, nullptr), "cannot write an H.264 film of this size and rate");
  }

  void OpenFile(const std::filesystem::path& file) {
    AVFormatContext* opened = nullptr;
    Check(avformat_alloc_output_context2(&opened, nullptr, "mp4", file.c_str()), "FFmpeg writes no MP4 files");
    format.reset(opened);
    format->flags |= AVFMT_FLAG_BITEXACT;
    stream = avformat_new_stream(opened, nullptr);
    GAITCAM_ASSERT(stream != nullptr);
    stream->time_base = codec->time_base;
    stream->avg_frame_rate = codec->framerate;
    Check(avcodec_parameters_from_context(stream->codecpar, codec.get()), "cannot describe the film");
    Check(avio_open(&opened->pb, file.c_str(), AVIO_FLAG_WRITE), "cannot write this file");
    Check(avformat_write_header(opened, nullptr), "cannot write this file");
  }

  void MakePicture(cv::Size size) {
    picture->format = AV_PIX_FMT_YUV420P;
    picture->width = size.width;
    picture->height = size.height;
    picture->pts = 0;
    Check(av_frame_get_buffer(picture.get(), 0), "no memory for a picture");
    to_yuv.reset(sws_getContext(size.width, size.height, AV_PIX_FMT_BGR24, size.width, size.height, AV_PIX_FMT_YUV420P,
                                SWS_BICUBIC, nullptr, nullptr, nullptr));
    GAITCAM_ASSERT(to_yuv != nullptr);
  }

  /// @param frame nothing: the film's end.
  void Send(const AVFrame* frame) {
    Check(avcodec_send_frame(codec.get(), frame), "cannot encode a picture");
    for (;;) {
      const int received = avcodec_receive_packet(codec.get(), packet.get());
      if (received == AVERROR(EAGAIN) || received == AVERROR_EOF) return;
      Check(received, "cannot encode a picture");
      packet->duration = 1;
      av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
      packet->stream_index = stream->index;
      Check(av_interleaved_write_frame(format.get(), packet.get()), "cannot write this file");
    }
  }
};

FilmEncoder::FilmEncoder(const std::filesystem::path& file, const std::string& name, cv::Size size_px,
                         double frame_rate_hz)
    : parts_(std::make_unique<Parts>()) {
  GAITCAM_ASSERT(size_px.width % 2 == 0 && size_px.height % 2 == 0);
  av_log_set_level(AV_LOG_FATAL);  // what fails is told in our own words
  parts_->name = name;
  parts_->OpenCodec(size_px, frame_rate_hz);
  parts_->OpenFile(file);
  parts_->MakePicture(size_px);
}

FilmEncoder::~FilmEncoder() = default;

void FilmEncoder::Add(const cv::Mat& bgr) {
  Parts& p = *parts_;
  GAITCAM_ASSERT(bgr.type() == CV_8UC3 && bgr.cols == p.codec->width && bgr.rows == p.codec->height);
  p.Check(av_frame_make_writable(p.picture.get()), "no memory for a picture");
  const uint8_t* const rows[1] = {bgr.data};
  const int strides[1] = {int(bgr.step)};
  sws_scale(p.to_yuv.get(), rows, strides, 0, bgr.rows, p.picture->data, p.picture->linesize);
  p.Send(p.picture.get());
  ++p.picture->pts;
}

void FilmEncoder::Finish() {
  parts_->Send(nullptr);
  parts_->Check(av_write_trailer(parts_->format.get()), "cannot write this file");
  parts_->Check(avio_closep(&parts_->format->pb), "cannot write this file");
}

}  // namespace gaitcam
