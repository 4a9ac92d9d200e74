// The part of UnityEngine that this package uses, without any doing: so that a compiler outside Unity checks the types.
using System;

namespace UnityEngine
{
    public class Object
    {
        public string name { get; set; }

        public static void Destroy(Object target)
        {
        }

        public static bool operator ==(Object a, Object b)
        {
            return ReferenceEquals(a, b);
        }

        public static bool operator !=(Object a, Object b)
        {
            return !ReferenceEquals(a, b);
        }

        public override bool Equals(object other)
        {
            return ReferenceEquals(this, other);
        }

        public override int GetHashCode()
        {
            return 0;
        }
    }

    public class Component : Object
    {
        public Transform transform { get { return null; } }

        public T GetComponent<T>()
        {
            return default(T);
        }
    }

    public class Behaviour : Component
    {
        public bool enabled { get; set; }
    }

    public class MonoBehaviour : Behaviour
    {
    }

    public class Transform : Component
    {
        public Vector3 position { get; set; }
    }

    public sealed class MeshFilter : Component
    {
        public Mesh sharedMesh { get; set; }
    }

    public class MeshRenderer : Component
    {
        public Material material { get; set; }
    }

    public class Material : Object
    {
    }

    public sealed class Camera : Behaviour
    {
        public static Camera main { get { return null; } }
    }

    public sealed class GameObject : Object
    {
        public GameObject(string name)
        {
            this.name = name;
        }

        public T AddComponent<T>() where T : Component
        {
            return default(T);
        }
    }

    public struct Vector3
    {
        public float x, y, z;

        public Vector3(float x, float y, float z)
        {
            this.x = x;
            this.y = y;
            this.z = z;
        }

        public static Vector3 zero { get { return new Vector3(); } }

        public static Vector3 operator -(Vector3 a, Vector3 b)
        {
            return new Vector3(a.x - b.x, a.y - b.y, a.z - b.z);
        }
    }

    public struct Color
    {
        public float r, g, b, a;

        public Color(float r, float g, float b, float a)
        {
            this.r = r;
            this.g = g;
            this.b = b;
            this.a = a;
        }
    }

    public struct Bounds
    {
        public Bounds(Vector3 center, Vector3 size)
        {
        }
    }

    public sealed class Mesh : Object
    {
        public Vector3[] vertices { get; set; }
        public Vector3[] normals { get; set; }
        public Color[] colors { get; set; }
        public int[] triangles { get; set; }
        public Bounds bounds { get; set; }
        public Rendering.IndexFormat indexFormat { get; set; }

        public int vertexCount { get { return 0; } }

        public void MarkDynamic()
        {
        }

        public void Clear()
        {
        }
    }

    public class Texture : Object
    {
        public int width { get { return 0; } }
        public TextureWrapMode wrapMode { get; set; }
        public FilterMode filterMode { get; set; }
    }

    public sealed class Texture2D : Texture
    {
        public Texture2D(int width, int height, TextureFormat format, bool mipChain, bool linear)
        {
        }

        public static Texture2D blackTexture { get { return null; } }

        public void SetPixelData<T>(T[] data, int mipLevel, int sourceDataStartIndex = 0)
        {
        }

        public void Apply(bool updateMipmaps, bool makeNoLongerReadable)
        {
        }
    }

    public enum TextureFormat
    {
        RGBAHalf,
        RGBAFloat,
    }

    public enum TextureWrapMode
    {
        Repeat,
    }

    public enum FilterMode
    {
        Bilinear,
    }

    public static class Mathf
    {
        public static float Round(float value)
        {
            return (float)Math.Round(value);
        }

        public static int Clamp(int value, int least, int most)
        {
            return Math.Min(most, Math.Max(least, value));
        }

        public static ushort FloatToHalf(float value)
        {
            return 0;
        }
    }

    public static class Debug
    {
        public static void Log(object message, Object context)
        {
        }

        public static void LogError(object message, Object context)
        {
        }

        public static void LogException(Exception exception, Object context)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class SerializeField : Attribute
    {
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class TooltipAttribute : Attribute
    {
        public TooltipAttribute(string tooltip)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class AddComponentMenu : Attribute
    {
        public AddComponentMenu(string menuName)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class DisallowMultipleComponent : Attribute
    {
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class RequireComponent : Attribute
    {
        public RequireComponent(Type first, Type second)
        {
        }
    }
}

namespace UnityEngine.Rendering
{
    public enum IndexFormat
    {
        UInt32,
    }
}
