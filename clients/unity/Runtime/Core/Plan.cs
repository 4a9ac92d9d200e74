// What to subscribe to: a wish, fitted to what `hello` offers.
using System;
using System.Collections.Generic;

namespace Swellcast
{
    /// <summary>What somebody would like to have.</summary>
    public sealed class Wish
    {
        /// <summary>Groups in order of need; those that the scene doesn't have are left out.</summary>
        public string[] Groups = { "displacement" };
        /// <summary>Frames a second; the nearest rate that there is.</summary>
        public int RateHz = 15;
        /// <summary>Name of an error class.</summary>
        public string Class = "1mm";
        /// <summary>Finest level of detail; 0 is the full grid.</summary>
        public int Level;
        public string Codec = "rans";
        /// <summary>Cascades, by index; null: all.</summary>
        public int[] Cascades;
        /// <summary>Ask for key frames each second, so that a recording can be entered there.</summary>
        public bool Keys;
        /// <summary>
        /// Tell the server how this client fares, so that it is given what it can take. One that keeps frames rather
        /// than shows them would have them all, however late.
        /// </summary>
        public bool Reports = true;
    }

    /// <summary>What is subscribed to.</summary>
    public sealed class Plan
    {
        public int RateHz;
        public bool Keys;
        public readonly List<UnitName> Units = new List<UnitName>();

        public static Plan Of(Hello hello, Wish wish)
        {
            var plan = new Plan { RateHz = NearestRate(hello, wish.RateHz), Keys = wish.Keys };
            string kind = hello.Classes.Length > 0 ? hello.Classes[0].Name : Names.Classes[0];
            foreach (ErrorClass offered in hello.Classes)
            {
                if (offered.Name == wish.Class) kind = wish.Class;
            }
            foreach (string group in wish.Groups)
            {
                if (Array.IndexOf(hello.Groups, group) < 0) continue;
                foreach (Cascade cascade in hello.Cascades)
                {
                    if (wish.Cascades != null && Array.IndexOf(wish.Cascades, cascade.Index) < 0) continue;
                    UnitName unit = UnitOf(cascade, group, kind, wish, plan.RateHz);
                    if (unit != null) plan.Units.Add(unit);
                }
            }
            while (plan.Units.Count > hello.MostUnits) plan.Units.RemoveAt(plan.Units.Count - 1);
            while (plan.Units.Count > 0 && plan.Message(Wire.MaxTick).Length > hello.MessageBytes)
            {
                plan.Units.RemoveAt(plan.Units.Count - 1);
            }
            return plan;
        }

        /// <summary>The message that asks for it.</summary>
        public string Message(long id)
        {
            return ClientMessages.Subscribe(id, RateHz, Units, Keys);
        }

        /// <summary>Ticks between frames of a unit.</summary>
        public int IntervalOf(UnitName unit)
        {
            return Wire.TicksPerSecond / (unit.RateHz > 0 ? unit.RateHz : RateHz);
        }

        public static int NearestRate(Hello hello, int wanted)
        {
            int nearest = hello.RatesHz[0];
            foreach (int rate in hello.RatesHz)
            {
                if (Math.Abs(rate - wanted) < Math.Abs(nearest - wanted)) nearest = rate;
            }
            return nearest;
        }

        /// <summary>A unit as fine and as often as it can be had; null where it can't be had at all.</summary>
        private static UnitName UnitOf(Cascade cascade, string group, string kind, Wish wish, int rateHz)
        {
            int finest = 0, rate = 0;
            foreach (Detail detail in cascade.Details)
            {
                if (detail.Group != group) continue;
                if (detail.RateHz == 0) return null;
                finest = detail.FinestLevel;
                if (detail.RateHz < rateHz) rate = detail.RateHz.Value;
            }
            int level = Math.Min(Math.Max(wish.Level, finest), cascade.Levels - 1);
            return new UnitName
            {
                Cascade = cascade.Index,
                Level = level,
                Class = kind,
                Group = group,
                Codec = wish.Codec,
                RateHz = rate,
            };
        }
    }
}
