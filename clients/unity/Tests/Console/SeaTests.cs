// The sea from frames: sums, wrapping, the particle that was displaced to a place, changes of level and of layout.
using System;
using System.Collections.Generic;

namespace Swellcast.Tests
{
    internal static class SeaTests
    {
        public static void Add(Tests tests)
        {
            tests.Add("sea: height between samples, and across the seam", Heights);
            tests.Add("sea: a particle that was moved is found", Moved);
            tests.Add("sea: blended in time, whole and at a place alike", Blended);
            tests.Add("sea: a unit comes coarser, and fine again", LevelChange);
            tests.Add("sea: a cascade counts at its own ticks alone", LayoutChange);
            tests.Add("sea: frames that are not asked for are of no use", Strangers);
            tests.Add("sea: a patch in tiles", Tiles);
            tests.Add("sea: fields for a picture, and their sum at a place", PictureFields);
        }

        private static Sea SeaOf(string hello, Sea before = null, params string[] groups)
        {
            var greeting = (Hello)ServerMessages.Read(hello);
            var wish = new Wish { Groups = groups.Length > 0 ? groups : new[] { "displacement" } };
            return new Sea(greeting, Plan.Of(greeting, wish), before);
        }

        private static bool Feed(Sea sea, byte[] frame)
        {
            return sea.Accept(new Decoder(0).Decode(frame, 0, frame.Length));
        }

        private static Func<int, int, int, int> HeightOf(int count)
        {
            return (channel, x, z) => channel == 1 ? count : 0;
        }

        private static void Heights()
        {
            Sea sea = SeaOf(Samples.Hello());
            Check.Same(sea.HeightAt(1, 2), 0f, "before any frame");
            Feed(sea, Samples.Frame(count: (channel, x, z) => channel == 1 ? x * 100 : 0));
            sea.Seek(7200);
            Check.Same(sea.Footing, Footing.Between, "footing");
            Check.Near(sea.HeightAt(10, 3), 0.25, 1e-6, "between");
            Check.Near(sea.HeightAt(10 + 640, 3 - 64), 0.25, 1e-6, "patches away");
            Check.Near(sea.HeightAt(-4, 0), 0.7, 1e-6, "across the seam");
            Check.Near(sea.HeightAt(-1e-18, 0), 0, 1e-6, "a hair before the origin");
            Check.Near(sea.HeightAt(double.NaN, 0), 0, 1e-6, "nowhere");
            sea.Seek(9000);
            Check.Same(sea.Footing, Footing.Starved, "footing");
            Check.Near(sea.HeightAt(10, 3), 0.25, 1e-6, "held");
        }

        private static void Moved()
        {
            Sea sea = SeaOf(Samples.Hello());
            Feed(sea, Samples.Frame(count: (channel, x, z) => channel == 0 ? 2000 : channel == 1 ? x * 100 : 0));
            sea.Seek(7200);
            Check.Near(sea.HeightAt(12, 5), 0.2, 1e-6, "all 4 m to the east");
        }

        private static void Blended()
        {
            Sea sea = SeaOf(Samples.Hello());
            for (int k = 0; k < 4; k++)
            {
                int frame = k;
                Feed(sea, Samples.Frame(tick: 7200 + 480 * k, count: (channel, x, z) => channel * 1000 + x * 10 + z + frame * frame * 40));
            }
            sea.Seek(7200 + 480 * 1.5);
            var samples = new float[8 * 8 * 4];
            for (int channel = 0; channel < 3; channel++)
            {
                Check.That(sea.Blend(0, Group.Displacement, channel, 8, samples, 4, channel), "there is something");
            }
            for (int i = 0; i < 64; i++)
            {
                double must = (1000 + i % 8 * 10 + i / 8 + 1.5 * 1.5 * 40) * 0.002;
                Check.Near(samples[4 * i + 1], must, 1e-5, "sample " + i);
                float dx, height, dz;
                sea.Displacement(i % 8 * 8, i / 8 * 8, out dx, out height, out dz);
                Check.Near(height, must, 1e-5, "place " + i);
                Check.Near(dz - height, 2, 1e-5, "dz of place " + i);
            }
            Check.That(!sea.Blend(0, Group.Foam, 0, 8, samples, 4, 3), "no foam");
            Check.That(!sea.Blend(0, Group.Displacement, 0, 16, samples, 4, 0), "no such size");
        }

        private static void LevelChange()
        {
            Sea sea = SeaOf(Samples.Hello(n: 16));
            foreach (int tick in new[] { 480, 960, 1440 }) Feed(sea, Samples.Frame(tick: tick, n: 16, count: HeightOf(100)));
            foreach (int tick in new[] { 1920, 2400, 2880 })
            {
                Check.That(Feed(sea, Samples.Frame(tick: tick, level: 1, count: HeightOf(50))), "coarser");
            }
            sea.Seek(1000);
            Check.Near(sea.HeightAt(1, 1), 0.2, 1e-6, "fine");
            Check.Near(sea.Ahead(1000), 1880, 0, "what is to come is held");
            sea.Seek(1700);
            Check.Near(sea.HeightAt(1, 1), 0.2, 1e-6, "the last fine one stays until then");
            sea.Seek(1930);
            Check.Near(sea.HeightAt(1, 1), 0.1, 1e-6, "coarse");
            Check.Same(sea.SizeOf(0, Group.Displacement), 8, "size");
            foreach (int tick in new[] { 3360, 3840 }) Feed(sea, Samples.Frame(tick: tick, n: 16, count: HeightOf(70)));
            sea.Seek(3370);
            Check.Near(sea.HeightAt(1, 1), 0.14, 1e-6, "fine again");
            Check.That(!Feed(sea, Samples.Frame(tick: 4320, n: 16, level: 1)), "a level of another size");
            Check.That(!Feed(sea, Samples.Frame(tick: 4320, level: 2)), "no such level");
            Check.That(!Feed(sea, Samples.Frame(tick: 4320, level: 200)), "no such level at all");
        }

        private static void LayoutChange()
        {
            Sea first = SeaOf(Samples.Hello());
            foreach (int tick in new[] { 3840, 4320, 4800, 5280 }) Feed(first, Samples.Frame(tick: tick, count: HeightOf(100)));
            string both = Samples.CascadeOf(1, 8, 0, 9600) + "," + Samples.CascadeOf(8, 8, 4800, null);
            Sea sea = SeaOf(Samples.Hello(cascades: both), first);
            sea.Seek(4700);
            Check.Near(sea.HeightAt(1, 1), 0.2, 1e-6, "frames of what goes on are there");
            first.Seek(4700);
            Check.Near(first.HeightAt(1, 1), 0.2, 1e-6, "and still where they were, until nobody looks there");
            sea.Seek(5000);
            Check.Near(sea.HeightAt(1, 1), 0.2, 1e-6, "what is not there counts as nothing");
            Check.Same(sea.Footing, Footing.Nothing, "the new one has no frame");
            Check.That(!Feed(sea, Samples.Frame(tick: 4320, cascade: 8)), "before it begins");
            foreach (int tick in new[] { 4800, 5280, 9600, 10080 })
            {
                Check.That(Feed(sea, Samples.Frame(tick: tick, cascade: 8, count: HeightOf(50))), "the new one");
            }
            sea.Seek(5100);
            Check.Near(sea.HeightAt(1, 1), 0.3, 1e-6, "both");
            sea.Seek(4700);
            Check.Near(sea.HeightAt(1, 1), 0.2, 1e-6, "the new one is held, and has not begun");
            sea.Seek(8300);
            Check.Same(sea.Footing, Footing.Between, "the end of a cascade is no starvation");
            sea.Seek(9700);
            Check.Near(sea.HeightAt(1, 1), 0.1, 1e-6, "the old one is over");
            Sea later = SeaOf(Samples.Hello(cascades: Samples.CascadeOf(8, 8, 9600, null)), sea);
            later.Seek(9700);
            Check.Near(later.HeightAt(1, 1), 0, 0, "another cascade of the same number is another");
        }

        private static void Strangers()
        {
            Sea sea = SeaOf(Samples.Hello());
            Check.That(!Feed(sea, Samples.Frame(cascade: 2)), "another cascade");
            Check.That(!Feed(sea, Samples.Frame(Group.Foam)), "another group");
            Check.That(!Feed(sea, Samples.Frame(n: 16)), "another size");
            Check.That(!Feed(sea, Samples.Frame(Group.Displacement, codec: Codec.F32, payload: new byte[768])), "floats");
            Check.That(Feed(sea, Samples.Frame()) && !Feed(sea, Samples.Frame()), "twice");
        }

        private static void Tiles()
        {
            Sea sea = SeaOf(Samples.Hello(n: 512), null, "foam");
            for (int tile = 0; tile < 4; tile++)
            {
                int number = tile;
                byte[] frame = Samples.Frame(Group.Foam, n: 256, count: (channel, x, z) => number * 100 + (z == 255 ? 7 : 0));
                Samples.Put(frame, 14, 512, 2);
                Samples.Put(frame, 16, tile % 2, 2);
                Samples.Put(frame, 18, tile / 2, 2);
                Samples.Seal(frame);
                Check.That(Feed(sea, frame), "tile " + tile);
            }
            sea.Seek(7200);
            var samples = new float[512 * 512];
            Check.That(sea.Blend(0, Group.Foam, 0, 512, samples, 1, 0), "foam");
            Check.Near(samples[0], 0, 1e-6, "first");
            Check.Near(samples[256], 0.2, 1e-6, "to the east");
            Check.Near(samples[255 * 512 + 256], 0.214, 1e-6, "its last row");
            Check.Near(samples[256 * 512], 0.4, 1e-6, "to the south");
            Check.Near(samples[512 * 512 - 1], 0.614, 1e-6, "last");
        }

        private static void PictureFields()
        {
            string both = Samples.CascadeOf(1, 8, 0, null) + "," + Samples.CascadeOf(2, 8, 0, null);
            string hello = Samples.Hello(cascades: both).Replace("\"foam\",\"channels\"", "\"normals\",\"channels\"");
            Sea sea = SeaOf(hello, null, "displacement", "normals");
            var fields = new SeaFields(sea);
            fields.Seek(7200);
            Check.Same(fields.Displacement(0).Size, 0, "size before any frame");
            Check.Same(fields.At(3, 4).NormalY, 1f, "flat");
            Feed(sea, Samples.Frame(count: (channel, x, z) => channel * 1000 + x * 100));
            Feed(sea, Samples.Frame(cascade: 2, count: (channel, x, z) => z * 50));
            Feed(sea, Samples.Frame(Group.Normals, cascade: 2, count: (channel, x, z) => channel == 0 ? 150 : -200));
            fields.Seek(7200);
            Check.Same(fields.Normals(0).Size, 0, "normals of the first");
            SurfacePoint point = fields.At(20, 12);
            Check.Near(point.DX, (250 + 75) * 0.002, 1e-6, "dx");
            Check.Near(point.Height, (1250 + 75) * 0.002, 1e-6, "height");
            Check.Near(point.DZ, (2250 + 75) * 0.002, 1e-6, "dz");
            double length = Math.Sqrt(0.3 * 0.3 + 1 + 0.4 * 0.4);
            Check.Near(point.NormalX, -0.3 / length, 1e-6, "to the west, where it rises to the east");
            Check.Near(point.NormalY, 1 / length, 1e-6, "up");
            Check.Near(point.NormalZ, 0.4 / length, 1e-6, "to the south, where it rises to the north");
            Check.Same(point.Foam, 0f, "foam");
            float dx, height, dz;
            sea.Displacement(20, 12, out dx, out height, out dz);
            Check.Near(point.Height, height, 1e-6, "the same as from frames");
        }
    }
}
