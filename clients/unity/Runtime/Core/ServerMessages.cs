// Text messages from the server (PROTOCOL.md section 3): each a class of its own, read and checked.
namespace Swellcast
{
    /// <summary>A message of the server that was understood: one of the classes of this file, or a `Hello`.</summary>
    public static class ServerMessages
    {
        /// <summary>Longest text that is taken, in characters: hundreds of cascades fit.</summary>
        public const int MostLength = 1 << 18;

        /// <returns>null for a type that this client doesn't know.</returns>
        /// <exception cref="MessageException">It can't be used.</exception>
        public static object Read(string text)
        {
            string type;
            Fields f = Fields.Read(text, MostLength, out type);
            switch (type)
            {
                case "hello": return Hello.Of(f);
                case "subscribed": return Subscribed.Of(f);
                case "points_subscribed": return PointsSubscribed.Of(f);
                case "time": return TimeAnswer.Of(f);
                case "quality": return Quality.Of(f);
                case "status": return Status.Of(f);
                case "change": return Change.Of(f);
                case "error": return ServerError.Of(f);
                default: return null;
            }
        }
    }

    /// <summary>What of a subscription was granted.</summary>
    public sealed class Subscribed
    {
        public long Id, FromTick;
        public int RateHz;
        public UnitName[] Units;

        internal static Subscribed Of(Fields f)
        {
            Fields[] units = f.Objects("units", 1 << 16);
            var message = new Subscribed
            {
                Id = f.Whole("id", 0, Wire.MaxTick),
                RateHz = (int)f.Whole("rate_hz", 0, Wire.TicksPerSecond),
                FromTick = f.Whole("from_tick", 0, Wire.MaxTick),
                Units = new UnitName[units.Length],
            };
            for (int i = 0; i < units.Length; i++) message.Units[i] = UnitName.Of(units[i]);
            return message;
        }
    }

    /// <summary>Points are followed from a tick on.</summary>
    public sealed class PointsSubscribed
    {
        public long Id, FromTick, Count;
        public int RateHz;

        internal static PointsSubscribed Of(Fields f)
        {
            return new PointsSubscribed
            {
                Id = f.Whole("id", 0, Wire.MaxTick),
                RateHz = (int)f.Whole("rate_hz", 0, Wire.TicksPerSecond),
                FromTick = f.Whole("from_tick", 0, Wire.MaxTick),
                Count = f.Whole("count", 0, int.MaxValue),
            };
        }
    }

    /// <summary>The server's part of a time exchange.</summary>
    public sealed class TimeAnswer
    {
        public double T0;
        public long T1Us, T2Us;

        internal static TimeAnswer Of(Fields f)
        {
            return new TimeAnswer
            {
                T0 = f.Number("t0"),
                T1Us = f.Whole("t1_us", -Wire.MaxTick, Wire.MaxTick),
                T2Us = f.Whole("t2_us", -Wire.MaxTick, Wire.MaxTick),
            };
        }
    }

    /// <summary>What is sent from now on where that differs from what was granted.</summary>
    public sealed class Quality
    {
        public int RateHz, Coarser;

        internal static Quality Of(Fields f)
        {
            return new Quality
            {
                RateHz = (int)f.Whole("rate_hz", 1, Wire.TicksPerSecond),
                Coarser = (int)f.Whole("coarser", 0, 255),
            };
        }
    }

    /// <summary>How the sea and the server are, once a second.</summary>
    public sealed class Status
    {
        public long Tick, Sequence;
        public double HsM;
        /// <summary>NaN where the sea is not wind-driven.</summary>
        public double WindMps = double.NaN, WindFromDeg = double.NaN;
        /// <summary>null where it is not said.</summary>
        public string Backend;
        /// <summary>Frames that the server could not make in time, since it started.</summary>
        public long SkippedFrames;

        internal static Status Of(Fields f)
        {
            var status = new Status
            {
                Tick = f.Whole("tick", 0, Wire.MaxTick),
                Sequence = f.Whole("sequence", 0, Wire.MaxTick),
                HsM = f.Number("hs_m"),
                Backend = f.Has("backend") ? f.Text("backend") : null,
                SkippedFrames = f.Has("skipped_frames") ? f.Whole("skipped_frames", 0, Wire.MaxTick) : 0,
            };
            if (!f.Has("wind")) return status;
            Fields wind = f.Object("wind");
            status.WindMps = wind.Number("speed_mps");
            status.WindFromDeg = wind.Number("direction_from_deg");
            return status;
        }
    }

    /// <summary>An entry of the control log.</summary>
    public sealed class Change
    {
        public long Sequence, EffectiveTick, TransitionTicks;
        /// <summary>`wind`, `water`, `layout`, or one that this client doesn't know.</summary>
        public string Kind;

        internal static Change Of(Fields f)
        {
            return new Change
            {
                Sequence = f.Whole("sequence", 0, Wire.MaxTick),
                EffectiveTick = f.Whole("effective_tick", 0, Wire.MaxTick),
                TransitionTicks = f.Whole("transition_ticks", 0, Wire.MaxTick),
                Kind = f.Object("change").Text("kind"),
            };
        }
    }

    /// <summary>The server refused something.</summary>
    public sealed class ServerError
    {
        public string Code, Detail;
        /// <summary>null where it does not apply.</summary>
        public string Field;
        public long? Id;

        internal static ServerError Of(Fields f)
        {
            return new ServerError
            {
                Code = f.Text("code"),
                Detail = f.Text("detail"),
                Field = f.Has("field") ? f.Text("field") : null,
                Id = f.Has("id") ? f.Whole("id", 0, Wire.MaxTick) : (long?)null,
            };
        }

        public override string ToString()
        {
            return Code + (Field == null ? "" : " " + Field) + ": " + Detail;
        }
    }
}
